"""Which part of a motion box a machine reaches, and a box that it reaches as a whole."""
