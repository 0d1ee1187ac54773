"""Tables of setpoints, proven as they are, and a judge of whatever becomes of them.

The judge looks at the positions alone, as drives would follow them.
"""

from collections.abc import Callable
from functools import cache

import numpy as np

from cases.base.errors import ProgramError
from cases.recording_format import setpoint_columns
from cases.schema import load_case
from cases.tables import own_units
from identification.limits.proof import limited_machine, prove
from identification.motion.motion import Joined, Motion, Standstill
from identification.motion.moves import StraightMove
from planner.families.fourier import FourierFamily
from postprocessors.dialects.setpoints.write import decimals_of, write_setpoints
from postprocessors.excitation import excitation_program
from postprocessors.program import dialect
from postprocessors.proof.proof import ProgramProof, prove_program
from tests.helpers import one_line
from tests.postprocessors.independent import derivatives_reached, share_of_limits, strut_lengths
from tests.postprocessors.programs import HOME

CASE = load_case("hexapod")
LIMITS = CASE.limits.motion
COLUMNS, DECIMALS = setpoint_columns(LIMITS.columns, struts=True), decimals_of(CASE)
UNITS = own_units(COLUMNS)
LANGUAGE = dialect("setpoints")
HEADER = "# format: hexcite setpoints 1"
CYCLE = 1e-3
T, POSE, RATES, ACCELERATIONS, STRUTS, TRIGGER = 0, slice(1, 7), slice(7, 13), slice(13, 19), slice(19, 37), 37


Table = np.ndarray
Edit = Callable[[Table], Table]


def cells(content: bytes) -> Table:
    return np.loadtxt([line for line in content.decode().splitlines() if line[0] not in "#t"], delimiter=",")


@cache
def moves() -> Table:
    """There and back with a pause, at 90 % of the limits."""
    limits = [0.9 * v for v in (LIMITS.rate, LIMITS.acceleration, LIMITS.jerk)]
    far = HOME + np.r_[0.02, -0.015, 0.01, 0.02, -0.01, 0.03]
    there, back = StraightMove.fastest(HOME, far, *limits), StraightMove.fastest(far, HOME, *limits)
    program = excitation_program(Joined((there, Standstill(far, 0.02), back)), CASE)
    return cells(write_setpoints(program, CASE))


@cache
def path() -> Table:
    """A Fourier motion of half a second that uses 85 % of its tightest limit."""
    family = FourierFamily(2, 0.5, 1, HOME, (LIMITS.coordinates[1] - LIMITS.coordinates[0]) / 2)
    unknowns = np.random.default_rng(1).normal(size=family.unknowns * 6)
    for _ in range(6):
        unknowns *= 0.85 / prove(family.motion(unknowns), CASE, 2000.0).worst_ratio
    return cells(write_setpoints(excitation_program(family.motion(unknowns), CASE), CASE))


TABLES = {"moves": moves, "path": path}


def as_csv(table: Table) -> bytes:
    row = ",".join(f"%.{digits}f" for digits in DECIMALS)
    return "\n".join([HEADER, ",".join(COLUMNS), *(row % tuple(cells) for cells in table), ""]).encode()


def proof(content: bytes, case=CASE) -> ProgramProof:
    reading = LANGUAGE.read(content, "t", case)
    return prove_program(reading, LANGUAGE.guarantees(reading, case))


def refused(content: bytes, case=CASE) -> bool:
    try:
        return not proof(content, case).ok
    except ProgramError as error:
        return one_line(error).startswith("t")


def renumbered(table: Table, cycle: float = CYCLE) -> Table:
    table[:, T] = np.arange(len(table)) * cycle
    return table


def with_its_struts(table: Table) -> Table:
    """The struts that belong to the poses: damage that no comparison of columns can see."""
    si = table * UNITS
    pose, rates, accelerations = (si[:, part].copy() for part in (POSE, RATES, ACCELERATIONS))
    motion = Motion(si[:, T], pose, rates, accelerations, np.zeros((len(si), 6)))
    table[:, STRUTS] = np.hstack(limited_machine(CASE).drives(motion)) / UNITS[STRUTS]
    return table


def fastest(table: Table) -> int:
    """The row at which it matters most."""
    return int(np.argmax(np.abs(table[:, 7])))


def share_as_driven(table: Table) -> float:
    """The largest share of a limit that drives use which follow the positions alone; above 1 it is dangerous.

    Tables that contradict themselves count as dangerous too: a controller may follow either column.
    """
    si = table * UNITS
    if not np.allclose(np.diff(si[:, T]), CYCLE, rtol=0.0, atol=1e-9):
        return np.inf
    times, pose, lengths = np.arange(len(si)) * CYCLE, si[:, POSE], si[:, 19:25]
    if np.abs(lengths - strut_lengths(pose, CASE)).max() > 2e-9 or np.abs(pose[[0]] - HOME).max() > 1e-8:
        return np.inf
    for values, rates, most in (
        (pose, si[:, RATES], LIMITS.jerk),
        (si[:, RATES], si[:, ACCELERATIONS], None),
        (lengths, si[:, 25:31], None),
        (si[:, 25:31], si[:, 31:37], None),
    ):
        middle = (values[2:] - values[:-2]) / (2 * CYCLE)
        off = np.abs(middle - rates[1:-1])
        if off.max() > (1e-4 if most is not None else 0.2):  # jerk h^2 / 6; h times a leap of acceleration
            return np.inf
    shares = [share_of_limits(times, pose, CASE)]
    for order, limit in ((1, LIMITS.strut_velocity_m_s), (2, LIMITS.strut_acceleration_m_s2)):
        shares.append(float(np.abs(derivatives_reached(times, lengths, order)).max()) / limit)
    return max(shares)
