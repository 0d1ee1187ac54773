"""Names of columns of recordings and motions, each with its unit, and the units that recordings may use instead."""

from collections.abc import Iterable, Mapping

from cases.units import DEG, MM, UM

CLOCK, TRIGGER, OVERRIDE = "t_s", "trigger", "override_percent"
STRUTS = tuple(f"l{k}_mm" for k in range(1, 7))
STRUT_VELOCITIES = tuple(f"ld{k}_mm_s" for k in range(1, 7))
DRIVES = tuple(f"q{k}_mm" for k in range(1, 7))
JOINT_ANGLES = tuple(f"q{k}_deg" for k in range(1, 13))
JOINT_WAYS = tuple(f"q{k}_mm" for k in range(7, 13))  # of a chain; those before are the names of drives too
DRIVE_VELOCITIES = tuple(f"qd{k}_mm_s" for k in range(1, 7))
POSE = ("x_mm", "y_mm", "z_mm", "a_deg", "b_deg", "c_deg")
ROTATION = tuple(f"r{i}{j}" for i in range(1, 4) for j in range(1, 4))
ACCELEROMETER = ("ax", "ay", "az")
BAR_FORCES = tuple(f"f{k}_N" for k in range(1, 7))
WRENCH = ("fx_N", "fy_N", "fz_N", "mx_Nm", "my_Nm", "mz_Nm")
COLUMNS = (
    CLOCK, *STRUTS, *STRUT_VELOCITIES, *DRIVES, *JOINT_ANGLES, *JOINT_WAYS,
    *DRIVE_VELOCITIES, *POSE, *ROTATION, *ACCELEROMETER, *BAR_FORCES,
    *WRENCH, TRIGGER, OVERRIDE,
)  # fmt: skip


def motion_columns(coordinates: tuple[str, ...]) -> tuple[str, ...]:
    """Columns of `motion.csv` and of tables of set points: coordinates, rates and accelerations over time."""
    return (CLOCK, *coordinates, *(f"v_{c}_s" for c in coordinates), *(f"acc_{c}_s2" for c in coordinates))


_LENGTH = {"mm": MM, "m": 1.0, "um": UM, "nm": 1e-9, "cm": 10.0 * MM, "in": 25.4 * MM}
_VELOCITY = {"mm/s": MM, "m/s": 1.0, "mm/min": MM / 60.0, "m/min": 1.0 / 60.0}
_ANGLE = {"deg": DEG, "rad": 1.0, "mrad": 1e-3}
_FORCE = {"N": 1.0, "kN": 1e3, "mN": 1e-3}
_MOMENT = {"Nm": 1.0, "Nmm": 1e-3, "kNm": 1e3}

# Groups of columns that one entry of `units` covers, and the units they may have; the first is that of our names.
_GROUPS: tuple[tuple[str, Iterable[str], Mapping[str, float]], ...] = (
    ("struts", STRUTS, _LENGTH),
    ("strut_velocities", STRUT_VELOCITIES, _VELOCITY),
    ("drives", (*DRIVES, *JOINT_WAYS), _LENGTH),
    ("joints", JOINT_ANGLES, _ANGLE),
    ("drive_velocities", DRIVE_VELOCITIES, _VELOCITY),
    ("positions", POSE[:3], _LENGTH),
    ("angles", POSE[3:], _ANGLE),
    ("forces", (*BAR_FORCES, *WRENCH[:3]), _FORCE),
    ("moments", WRENCH[3:], _MOMENT),
    ("override", (OVERRIDE,), {"%": 0.01, "1": 1.0}),
)
GROUP_UNITS = {name: units for name, _, units in _GROUPS}
_GROUP_OF = {column: name for name, columns, _ in _GROUPS for column in columns}


def units_of(name: str) -> Mapping[str, float]:
    """Units that a group or column may have in a file, with their SI values; empty where it has none."""
    return GROUP_UNITS.get(_GROUP_OF.get(name, name), {})


def si_factor(column: str, units: Mapping[str, str]) -> float:
    """SI value of the file's unit of a column: its own entry in `units`, else its group's, else that of its name."""
    group = _GROUP_OF.get(column)
    if group is None:
        return 1.0
    known = GROUP_UNITS[group]
    return known[units.get(column, units.get(group, next(iter(known))))]
