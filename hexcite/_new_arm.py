"""The beginning of a case file for an arm, from its URDF file."""

from pathlib import Path

from cases.base.atomic import write_text
from cases.chain import Chain
from cases.scaffold import arm_text, new_place
from cases.urdf import Arm, read_urdf


def new_arm(
    name: str,
    urdf: Path | str,
    flange: str | None = None,
    folder: Path | str | None = None,
    sensor: str | None = None,
    bodies: bool = False,
) -> Path:
    """Writes `folder/case.toml` with the chain of a URDF file; keys that no URDF has are there as comments.

    >>> file = hx.new_arm("arm", "robot.urdf", "tool0")
    >>> [joint.name for joint in hx.load_case(file).chain.joints][:2]
    ['shoulder_pan_joint', 'shoulder_lift_joint']

    What is odd about the file stands in the case as comments too.

    Args:
        flange: link that carries the sensor.
        folder: folder to make; named after the case unless given.
        sensor: link whose frame is the sensor's; that of the flange unless given.
        bodies: whether bodies that cover the file's collision geometry are kept apart; else they are comments.

    Raises:
        CaseError: a name that a case cannot have; the URDF file is not sound or has no such link.
        FileProblem: the folder holds a case, or cannot be written.
    """
    return begin_arm(name, urdf, flange, folder, sensor, bodies)[0]


def begin_arm(
    name: str, urdf: Path | str, flange: str | None, folder: Path | str | None, sensor: str | None, bodies: bool
) -> tuple[Path, tuple[str, ...]]:
    """As `new_arm`: the case file, and what is odd about the URDF file, each in a sentence."""
    file = new_place(name, folder)
    arm = read_urdf(Path(urdf), flange, sensor)
    touching = _touching(arm) if bodies else ()
    write_text(file, arm_text(name, arm, Path(urdf).name, flange, sensor, bodies, touching))
    return file, arm.notes


def _touching(arm: Arm) -> tuple[tuple[str, str], ...]:
    """Names of bodies that touch wherever the joints stand."""
    from identification.machines.always_touching import always_touching  # CasADi, which a case without bodies needs not

    joints = [
        joint.model_copy(update={"bodies": bodies})
        for (joint, _), bodies in zip(arm.joints, arm.bodies or [()] * len(arm.joints), strict=True)
    ]
    return always_touching(Chain(joints=tuple(joints), sensor=arm.sensor, base=arm.standing, tool=arm.tool))
