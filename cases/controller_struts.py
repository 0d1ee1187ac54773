"""How the drives of the struts are set up for point-to-point moves, which controllers make straight in the struts."""

from typing import Literal

from cases.parts import Part, Positive


class PointToPointDrives(Part):
    """What each strut does at most in a point-to-point move; the same for all six.

    These are machine data of the axes, on SINUMERIK those of the dynamic mode in which the program runs.
    """

    strut_velocity_m_s: Positive
    """Largest velocity of a drive in such moves."""
    strut_acceleration_m_s2: Positive
    """Largest acceleration of a drive in such moves."""
    strut_jerk_m_s3: Positive
    """Largest jerk of a drive in such moves."""
    feed: Literal["time", "rapid"]
    """What moves them: G1 with the block's time (G93), if the control takes F for a time there too, which no manual
    states: try it with `--speed 0.1`; or G0, as fast as the drives can, which cannot be slowed."""
