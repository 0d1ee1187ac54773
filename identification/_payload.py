"""The payload of two runs: recordings are identified first, results are taken as they are."""

from identification.identify import identify
from identification.recording.recording import Recording
from identification.results import payload as of_results
from identification.results.payload import Payload
from identification.results.result import Result


def payload(before: Result | Recording, after: Result | Recording) -> Payload:
    """The body that was mounted from one run to another: mass, centre of gravity, inertia.

    >>> empty, loaded = hx.Result.load("empty-result"), hx.Result.load("loaded-result")
    >>> mass = hx.payload(empty, loaded)["m"]
    >>> f"{mass.value:.2f} +- {mass.reported:.2f} {mass.unit}"
    '19.92 +- 0.01 kg'

    Args:
        before: result without the payload, or a recording, which is identified as `hx.identify` does it; a recording
            that does not say which machine it is from is one of the other's machine.
        after: the same with the payload.

    Raises:
        IdentificationError: both are of the same recording, the difference in mass is not significant, or a recording
            does not determine its parameters.
        RecordingError: a recording cannot be evaluated, or neither says which machine it is from.
        FileProblem: parameters of another case.
    """
    empty, loaded = (
        part if isinstance(part, Result) else identify(part, part.machine_case(part.case or other.case))
        for part, other in ((before, after), (after, before))
    )
    return of_results.payload(empty, loaded)
