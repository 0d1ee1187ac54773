"""The model of a force-measuring machine, recordings of it, and the parameters that follow from them."""

from typing import TYPE_CHECKING

from cases.base.doors import door

if TYPE_CHECKING:
    from identification._payload import payload as payload
    from identification.estimation.estimators import Method as Method
    from identification.estimation.priors import Prior as Prior
    from identification.finding import Finding as Finding
    from identification.looks.look import Look as Look
    from identification.looks.looking import look as look
    from identification.model.model import Model as Model
    from identification.model_choice import ModelChoice as ModelChoice
    from identification.model_choice import identify_models as identify_models
    from identification.recording.recording import Recording as Recording
    from identification.recording.recording import read as read
    from identification.results.force import force as force
    from identification.results.force import verify as verify
    from identification.results.history import History as History
    from identification.results.history import history as history
    from identification.results.identifiability import Identifiability as Identifiability
    from identification.results.pooling import pool as pool
    from identification.results.result import Result as Result
    from identification.results.taring import tare as tare
    from identification.results.verdicts import Verdict as Verdict
    from identification.results.verdicts import accept as accept
    from identification.samples.treatment import Treatment as Treatment

PUBLIC = {
    "payload": "identification._payload",
    "Method": "identification.estimation.estimators",
    "Prior": "identification.estimation.priors",
    "Finding": "identification.finding",
    "Look": "identification.looks.look",
    "look": "identification.looks.looking",
    "Model": "identification.model.model",
    "ModelChoice": "identification.model_choice",
    "identify_models": "identification.model_choice",
    "Recording": "identification.recording.recording",
    "read": "identification.recording.recording",
    "force": "identification.results.force",
    "tare": "identification.results.taring",
    "verify": "identification.results.force",
    "History": "identification.results.history",
    "history": "identification.results.history",
    "Identifiability": "identification.results.identifiability",
    "pool": "identification.results.pooling",
    "Result": "identification.results.result",
    "Verdict": "identification.results.verdicts",
    "accept": "identification.results.verdicts",
    "Treatment": "identification.samples.treatment",
}
"""Public names, and the modules that they are imported from when they are first used."""
__getattr__, __dir__ = door(__name__, PUBLIC)
