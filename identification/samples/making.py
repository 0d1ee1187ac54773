"""Samples of a run that is clean: averaged standstills, a robot's turns and accelerations, or a motion of drives."""

from dataclasses import replace

from cases.schema import Case
from identification.model.model import Model
from identification.samples.moving_window import moving_run
from identification.samples.sample_checks import CleanRun
from identification.samples.samples import Samples
from identification.samples.standstills import standstills
from identification.samples.treatment import Treatment
from identification.samples.wrist import narrow_run, widest_band, wrist_run


def evaluated_samples(clean: CleanRun, case: Case, model: Model, treatment: Treatment | None = None) -> Samples:
    """The samples of a run, ready to be evaluated; with another treatment where one is asked for."""
    recording = clean.recording
    if treatment is not None:
        return treatment.run(recording, case, model)
    if recording.t is None or case.setup == "1a":
        return standstills(recording, case, model)
    if recording.drives is None:
        run = wrist_run(recording, case, model)
        wide = wrist_run(recording, case, model, widest_band(recording, *recording.others), run.filter.cutoff)
        return replace(run, wide=wide, narrow=narrow_run(recording, case, model))
    return moving_run(recording, case, model)
