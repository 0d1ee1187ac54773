"""How far a path of POLY blocks may be off its time: what the controller's own law within each block can make of it."""

import numpy as np

from cases.schema import Case
from cases.units import DEG, MM
from identification.trajectories.polynomial import PolynomialMotion
from postprocessors.polynomials import Pieces, path_speed_deviation
from postprocessors.proving.guarantees import Forecast
from postprocessors.proving.stretches import Timed, stretches
from postprocessors.reading.words import Reading


def sinumerik_forecast(reading: Reading, case: Case) -> Forecast:
    """What is known of the time within POLY blocks: each ends in time, how it passes is the controller's."""
    found = [s.points for s in stretches(reading) if isinstance(s, Timed) and isinstance(s.points, PolynomialMotion)]
    if not found:
        return Forecast()
    off = [path_speed_deviation(_pieces(motion), motion) for motion in found]
    position, angle = max(o.position for o in off), max(o.angle for o in off)
    return Forecast(
        1.0,
        (
            f"time within a POLY block is the controller's: at constant path speed in each block it strays up to "
            f"{position / MM:.2g} mm and {angle / DEG:.2g} deg from the plan; a shorter controller.sinumerik."
            "poly_block_ms leaves it less",
        ),
    )


def _pieces(motion: PolynomialMotion) -> Pieces:
    degree = max(len(p.coefficients) for p in motion.pieces)
    coefficients = np.zeros((len(motion.pieces), degree, 6))
    for k, piece in enumerate(motion.pieces):
        powers = piece.duration ** np.arange(len(piece.coefficients))
        coefficients[k, : len(powers)] = piece.coefficients * powers[:, None]
    return Pieces(motion.times, coefficients)
