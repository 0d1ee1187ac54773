"""How an estimate answers to its forces: by the filter and the least squares of the run itself, both of them linear."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from identification.findings.plausibility import scan
from identification.hexapod import Hexapod
from identification.model import identification_model
from identification.recording import Recording
from identification.result import Estimate
from identification.runs.evaluation import Run
from identification.runs.preparation import moving_run, standstills

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class LinearAnswer:
    """What parameters become of forces.

    Args:
        forces: as evaluated, shape (n, 6) [N].
        matrices: A_j of the parameters alone, shape (n, 6, u).
        answer: u = sum over j of answer_j f_j, what is estimated beside u included, shape (u, n, 6).
        poses: of the evaluated samples, shape (n, 6) [m, rad].
        run: a moving run with its filter; None where it stands.
    """

    forces: Array
    matrices: Array
    answer: Array
    poses: Array
    run: Run | None

    def seen(self, added: Array) -> Array:
        """Forces of all samples of the recording as the evaluation sees them, shape (n, 6) [N]."""
        return added if self.run is None else self.run.filter.apply(added)[self.run.rows]

    def left(self, truth: Array) -> Array:
        """Evaluated forces less those of some parameters u, shape (n, 6) [N]."""
        return np.asarray(self.forces - self.matrices @ truth)

    def of(self, forces: Array) -> Array:
        """What evaluated forces, shape (n, 6, k) [N], move the parameters by, shape (u, k) [SI]."""
        return np.asarray(np.tensordot(self.answer, forces, axes=2))


def linear_answer(case: Case, recording: Recording, estimate: Estimate) -> LinearAnswer:
    """The answer of an estimate by least squares, at its delay.

    Args:
        case: of the recording.
        recording: that was identified, averaged where it stands.
        estimate: of it.
    """
    model = identification_model(case, estimate.model, estimate.terms)
    struts, run, forces = recording.struts, None, recording.forces
    assert struts is not None
    if recording.t is None:
        matrices = columns = standstills(recording, case, model).matrices
        weights = np.ones(len(matrices)) if recording.weights is None else recording.weights
    else:
        run = moving_run(recording, case, model, found=scan(recording, case))
        run = replace(run, smoothing="smoothing_s2" in estimate.told)
        delay = 0.0 if estimate.delay is None else estimate.delay.value
        forces, columns = run.forces, run.linearised(delay, estimate.values)
        matrices = columns[:, :, : len(estimate.values)]
        weights = np.ones(len(matrices))
        struts = struts[np.asarray(run.rows) + run.filter.margin]
    scale = weights[:, None] * np.sqrt(estimate.w)
    design = (columns * scale[:, :, None]).reshape(-1, columns.shape[2])
    size = np.linalg.norm(design, axis=0)
    answer = (np.linalg.pinv(design / size) / size[:, None]).reshape(len(size), len(columns), 6)[: matrices.shape[2]]
    return LinearAnswer(forces, matrices, answer * scale, Hexapod.of(case).poses(struts), run)
