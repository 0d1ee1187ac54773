"""What a SINUMERIK guarantees beyond a program's text."""

import math

import numpy as np

from cases.base.phrases import phrase
from cases.base.units import MS
from cases.controller import Sinumerik, SinumerikAxes
from cases.schema import Case
from identification.limits.limit import LimitKind
from identification.motion.curves import PolynomialMotion
from postprocessors.proof.guarantees import LONGEST_POINTS, SEVEN_SEGMENTS, Guarantees
from postprocessors.reading import Reading, Timed

OVERRIDE = phrase("override_sinumerik", "keep it at 100 % at most, or end the knob there (MD12030)")


def sinumerik_guarantees(reading: Reading, case: Case) -> Guarantees:
    """Guarantees of SINUMERIK: SOFT limits jerk; the control times blocks by its law and must enforce other limits."""
    settings = case.need_settings(SinumerikAxes, "a SINUMERIK program")
    polynomial = any(isinstance(s, Timed) and isinstance(s.points, PolynomialMotion) for s in reading.stretches)
    return Guarantees(
        case,
        controller="SINUMERIK",
        shortest_block=settings.shortest_block_ms * MS,
        longest_block=math.inf if polynomial else LONGEST_POINTS,
        enforced=frozenset(map(LimitKind, settings.controller_keeps)),
        law=SEVEN_SEGMENTS,
        resolution=1e-3,  # the usual number of increments of a millimetre and a degree (MD10200, MD10210)
        timing_remedy=f"make such blocks longer (controller.{'sinumerik.poly_' if polynomial else ''}block_ms)",
        override_remedy=OVERRIDE,
        tolerance=np.repeat(settings.poly_tolerance, 3) if isinstance(settings, Sinumerik) else np.zeros(1),
    )
