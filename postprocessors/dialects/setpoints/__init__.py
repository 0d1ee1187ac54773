"""Tables of setpoints, one row a control cycle."""
