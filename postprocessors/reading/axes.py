"""The axes of a machine whose joints they are, by the names of the joints."""

from cases.chain import Chain
from cases.errors import ProgramError


def axis_letters(chain: Chain, controller: str, file: str, endless: bool = True) -> str:
    """The axis of each joint of a chain, which is the joint's name.

    Args:
        controller: name of the controller, for messages.
        file: name of the program, for messages.
        endless: whether its axes that turn without end count their turns.

    Raises:
        ProgramError: a joint whose name is not an axis of its kind, or whose turns the controller does not count.
    """
    for joint in chain.joints:
        letters = "ABC" if joint.turns else "XYZ"
        if joint.name not in tuple(letters):
            problem = f"joint {joint.name} {'turns' if joint.turns else 'slides'} and is not an axis of {controller}"
            remedy = (
                f"name it {', '.join(letters)} in machine.chain, or write with --dialect urscript, ros2 or setpoints"
            )
            raise ProgramError(file, 0, 0, f"{problem}; {remedy}")
        if joint.kind == "continuous" and not endless:
            problem = (
                f"joint {joint.name} turns without end: as a modulo axis it would not count its turns on {controller}"
            )
            remedy = 'set the axis up without modulo, and state it as kind = "revolute" with position_deg'
            raise ProgramError(file, 0, 0, f"{problem}; {remedy}")
    return "".join(chain.names)
