"""The model of a force-measuring machine, recordings of it, and the parameters that follow from them."""

from typing import TYPE_CHECKING

from cases import door

if TYPE_CHECKING:
    from identification.estimation.estimators import method as method
    from identification.external import force as force
    from identification.external import tare as tare
    from identification.finding import Finding as Finding
    from identification.formats.look import look as look
    from identification.formats.looked import Look as Look
    from identification.outcome import Result as Result
    from identification.recording import Recording as Recording
    from identification.recording import read as read

__getattr__, __dir__ = door(
    __name__,
    {
        "identification.estimation.estimators": "method",
        "identification.external": "force tare",
        "identification.finding": "Finding",
        "identification.formats.look": "look",
        "identification.formats.looked": "Look",
        "identification.outcome": "Result",
        "identification.recording": "Recording read",
    },
)
