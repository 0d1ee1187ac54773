"""Whether a request can be met at all, as far as that is known before any search: refused at once, not in minutes."""

from collections.abc import Mapping

import numpy as np

from cases.errors import IdentificationError
from cases.schema import Case
from identification.evaluate import over_samples
from identification.model import Model, identification_model
from identification.reference import uniform_states
from planner.infeasible import require_rest
from planner.request import Request
from planner.target import parse_targets

STATES, SEED = 400, 0  # of the box, at which the regressor is looked at
HIDDEN = 1e-9  # of a column, below which a direction counts as unseen


def require_plannable(request: Request, case: Case) -> None:
    """Refuses what no search can mend.

    Raises:
        CaseError: the case has no machine, limits, controller or payload of this number.
        IdentificationError: an unknown model, or one that no motion of the machine determines.
        HexciteError: targets that cannot be read, a duration too short for the machine.
        InfeasiblePlan: standing still in the middle of the motion box passes a limit.
        FileProblem: the sequence cannot be used.
    """
    case.need_motion("planning")
    require_identifiable(case, identification_model(case, request.model))
    case.body(request.payload)
    parse_targets(request.targets, case, request.model)
    request.family.require_plannable(case, request.duration)
    require_rest(case)


def require_identifiable(case: Case, model: Model) -> None:
    """Refuses a machine that cannot move its load in all the ways that a model needs, whatever the motion.

    Raises:
        IdentificationError: the message names the parameters that stay unknown, and what of them is known together.
    """
    matrices = over_samples(model.coordinate_regressor, *uniform_states(case, STATES, SEED))[0]
    columns = matrices.reshape(-1, len(model.parameters))
    size = np.linalg.norm(columns, axis=0)
    if np.linalg.matrix_rank(columns / np.where(size > 0.0, size, 1.0), tol=HIDDEN * len(columns) ** 0.5) == len(size):
        return
    from identification.identifiability import analyse  # SciPy, for the few who need it

    found = analyse(matrices.reshape(STATES, -1, len(size)), model.names)
    words = []
    for group in found.groups:
        known = " and ".join(_sum(combination) for combination in group.combinations)
        words.append(f"{', '.join(group.parameters)}{f' (only {known})' if known else ''}")
    raise IdentificationError(
        f"case {case.name}, limits.motion: no motion in this box determines {'; '.join(words)}: the machine does not "
        f"turn or accelerate its load about enough axes; widen the box, or choose a smaller model than {model.number}"
    )


def _sum(combination: Mapping[str, float]) -> str:
    return " + ".join(
        name if factor == 1.0 else f"{factor:.3g} {name}" for name, factor in combination.items()
    ).replace("+ -", "- ")
