"""A program and logs that tests of LinuxCNC share."""

import numpy as np

from postprocessors.execute import ControllerLog

PROGRAM = """G17 G21 G40 G49 G54 G80 G90 G94
(G4 P99 in a comment is not a dwell)
G61
G0 X10 Y5 Z905 A2 B-3 C4
G4 P0.25
G64 P0.01 Q0
M62 P0
G1 X20 Y0 Z900 A0 B0 C0 F3000
G1 X-20 Y10 Z910 A5 B5 C-5
M63 P0
G4 P0.1
G4 P0.1
G0 X0 Y0 Z900 A0 B0 C0
G4 P0.05
M2
"""


def log_of(lines: list[int]) -> ControllerLog:
    count = len(lines)
    return ControllerLog(
        "none", 1e-3, np.ones((count, 6)), np.zeros((count, 6)), np.zeros(count, dtype=bool), np.array(lines)
    )
