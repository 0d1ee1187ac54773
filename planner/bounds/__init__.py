"""How much information the motion box of a case can hold: designs, and certificates of their optimality."""
