"""The model of a force-measuring machine, recordings of it, and the parameters that follow from them."""

from typing import TYPE_CHECKING

from cases import door

if TYPE_CHECKING:
    from identification.estimation.estimators import Method as Method
    from identification.estimation.priors import Prior as Prior
    from identification.external import force as force
    from identification.external import tare as tare
    from identification.external import verify as verify
    from identification.finding import Finding as Finding
    from identification.identifiability import Identifiability as Identifiability
    from identification.looks import Look as Look
    from identification.looks import look as look
    from identification.model import Model as Model
    from identification.model_choice import ModelChoice as ModelChoice
    from identification.model_choice import identify_models as identify_models
    from identification.outcome import Result as Result
    from identification.payloads import payload as payload
    from identification.pooling import pool as pool
    from identification.recording import Recording as Recording
    from identification.recording import read as read
    from identification.runs.treatment import Treatment as Treatment
    from identification.verdicts import Verdict as Verdict
    from identification.verdicts import accept as accept

__getattr__, __dir__ = door(__name__)
