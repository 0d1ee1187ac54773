"""Kinematics of machines: hexapods and serial chains as CasADi expressions, and motions that they executed."""
