"""The machine of a case: a line here for each kind of machine."""

from cases.base.errors import CaseError
from cases.schema import Case
from identification.machines.hexapod import Hexapod
from identification.machines.machine import Machine
from identification.machines.serial_chain import SerialChain


def machine_of(case: Case) -> Machine:
    """The machine of a case; raises CaseError where it has none, or one that does not move the sensors."""
    return SerialChain.of(case) if case.chain is not None else Hexapod.of(case)


def machine_if_any(case: Case) -> Machine | None:
    """The machine of a case; None where it has none that can be planned for."""
    try:
        return machine_of(case)
    except CaseError:
        return None
