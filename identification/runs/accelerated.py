"""Selection of highly accelerated sections of a moving run (section 7 of the paper).

The filter has seen the whole run before samples are chosen, forces and struts alike: sections have no ends that it
would feel, and a sample is judged by the same smoothed accelerations that enter the regressor. Robust deviations take
the sections as if they followed each other without gaps.
"""

from typing import Any, NamedTuple

import numpy as np

from cases.errors import RecordingError
from identification.result import Estimate
from identification.runs.conditioning import Accelerated
from identification.runs.evaluation import Run

NO_DIFFERENCE = 1.02  # of standard deviations, below which neither is preferred


class Section(NamedTuple):
    """What was chosen.

    Args:
        run: with these samples alone.
        threshold: strut acceleration that all of them reach [m/s^2].
        kept: evaluated samples.
        of: so many.
    """

    run: Run
    threshold: float
    kept: int
    of: int


def accelerated(run: Run, wish: Accelerated) -> Section:
    """The samples of a run at which the most accelerated strut reaches a threshold.

    Args:
        run: ready to be evaluated.
        wish: share of the samples, or the threshold.

    Raises:
        RecordingError: no sample reaches it.
    """
    struts = run.recording.struts
    assert struts is not None
    size = np.abs(run.filter.apply(struts, 2)[run.rows]).max(axis=1)
    threshold = float(np.quantile(size, 1.0 - wish.share)) if wish.least is None else wish.least
    keep = size >= threshold
    if keep.sum() < 2:
        raise RecordingError(
            f"--accelerated {threshold:g}m/s^2: no strut is accelerated so much, at most {size.max():.4g} m/s^2 behind "
            "the filter; give less, or a share as --accelerated 50%"
        )
    return Section(run.without(~keep), threshold, int(keep.sum()), len(keep))


def compared(section: Section, chosen: Estimate, whole: Estimate) -> tuple[str, dict[str, Any]]:
    """What the selection did to the standard deviations, for people and for programs.

    Args:
        section: the selection.
        chosen: estimate from it.
        whole: estimate from all samples.
    """
    pairs = [(v.reported, whole.physical[n].reported) for n, v in chosen.physical.items()]
    ratios = [a / b for a, b in pairs if a > 0.0 and b > 0.0]
    ratio = float(np.exp(np.mean(np.log(ratios)))) if ratios else 1.0
    favours = "neither"
    if not 1.0 / NO_DIFFERENCE <= ratio <= NO_DIFFERENCE:
        favours = "all samples" if ratio > 1.0 else "the selection"
    share = 100 * section.kept / section.of
    note = (
        f"accelerated: {chosen.samples} of {whole.samples} samples ({share:.3g} %), where a strut is accelerated by "
        f"{section.threshold:.3g} m/s^2 or more; standard deviations are {ratio:.3g} times those of all samples "
        f"(geometric mean of {len(ratios)}), which favours {favours}"
    )
    told = {
        "threshold_m_s2": section.threshold,
        "samples": chosen.samples,
        "samples_of_all": whole.samples,
        "share": section.kept / section.of,
        "std_ratio": ratio,
        "favours": favours,
    }
    return note, {"accelerated": told}
