"""What it takes until a solver begins: problem, derivatives, solver, for the largest problem of each family."""

from time import process_time

import numpy as np

from cases.loading import load_case
from identification.criteria import CRITERIA
from identification.model import identification_model
from identification.reference import reference_scaling
from planner.families.family import Family, box_middle
from planner.families.fourier import FINE, FourierFamily
from planner.families.ptp import MOST, PointToPointFamily
from planner.families.spline import MOST as MOST_INTERVALS
from planner.families.spline import SplineFamily
from planner.search.lifted import lifted
from planner.search.problem import build_problem
from planner.search.solvers import FAR, SOLVERS, Program
from planner.search.solving import SHARPER, SHARPNESS, random_start


def building_rows() -> list[list[str]]:
    """Rows of the table of figures: CPU time of all but the iterations."""
    case = load_case("hexapod")
    families: dict[str, Family] = {
        "fourier, order 7": FourierFamily.lasting(7, 4.0, 3, *box_middle(case), FINE),
        f"ptp, {MOST} moves": PointToPointFamily.of(case, MOST, 18.0),
        f"spline, {MOST_INTERVALS} knots": SplineFamily.of(case, MOST_INTERVALS, 15.0),
    }
    model = identification_model(case, 9)
    scaling = reference_scaling(case, model)
    rows = []
    for name, family in families.items():
        start = random_start(0, family, build_problem(case, model, family, scaling))
        seconds = {}
        for criterion in CRITERIA:
            began = process_time()
            problem = build_problem(case, model, family, scaling)
            active = np.ones_like(problem.held_from_the_start())  # every non-linear limit
            objective = problem.objective(criterion, SHARPNESS[-1])
            constraints = problem.constraints(active)
            sampling = problem.sampling
            program = Program(problem.unknowns, objective, constraints, sampling.lower, sampling.upper)
            SOLVERS["sqp"](program, start, 0, lambda objective: True)
            seconds[criterion] = process_time() - began
        began = process_time()
        problem = build_problem(case, model, family, scaling)
        raised = lifted(problem, np.ones_like(problem.held_from_the_start()), "K", SHARPER[-1], FAR)
        SOLVERS["ipopt"](raised.program, raised.start(start), 0, lambda objective: True)
        seconds["K, exact second derivatives"] = process_time() - began
        slowest = max(seconds, key=lambda criterion: seconds[criterion])
        rows.append([f"building {name}, every limit held, criterion {slowest}", f"{seconds[slowest]:.2f} s", "2 s"])
    return rows
