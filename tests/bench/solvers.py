"""The paper's study of criteria, orders and solvers (section 7), and what each criterion gains."""

from dataclasses import dataclass

import numpy as np

from cases.loading import load_case
from cases.schema import Case
from identification.criteria import CRITERIA
from planner.cli.console import print_table
from planner.families.family import box_middle
from planner.families.fourier import FINE, FourierFamily
from planner.parallel import Listener, run_all
from planner.planning import search
from planner.request import SOLVER_NAMES, Request
from planner.solving import Failed, Stage, Start, Task, seeds_of

PERIOD = 3.0  # [s]
PERIODS = 4
ORDERS = range(1, 8)  # order 1 with run-in and run-out
STARTS = 2  # of each cell, the same for every criterion and solver
MANY = 20  # of D and order 5
WHOLE = Stage("study", 1000, True)
SILENT = Listener(lambda start: None, lambda news: None)


@dataclass(frozen=True, slots=True)
class Cell:
    """What came of the starts of one criterion, order and solver."""

    criterion: str
    order: int
    solver: str
    results: tuple[Start | Failed, ...]

    @property
    def row(self) -> list[str]:
        """As a row of the table."""
        done = [r for r in self.results if isinstance(r, Start)]
        converged = sum(r.converged for r in done)
        words = [self.criterion, str(self.order), self.solver, f"{converged} of {len(self.results)}"]
        if not done:
            return [*words, "-", "-", "-"]
        iterations, seconds = (float(np.median([getattr(r, k) for r in done])) for k in ("iterations", "seconds"))
        return [*words, f"{iterations:.0f}", f"{seconds:.1f} s", f"{max(r.score for r in done):.4g}"]


def study_cell(case: Case, criterion: str, order: int, solver: str, starts: int) -> Cell:
    """Runs the starts of a cell, from random motions to the full problem with every limit, in parallel processes."""
    family = FourierFamily.lasting(order, PERIOD, PERIODS, *box_middle(case), FINE)
    tasks = [Task(case, 9, family, criterion, solver, WHOLE, seed) for seed in seeds_of(0, starts)]
    return Cell(criterion, order, solver, tuple(run_all(tasks, SILENT).results))


def paper_study() -> None:
    """Prints the table of section 7: criteria x orders x solvers from the same starts."""
    case = load_case("hexapod")
    rows = [
        study_cell(case, criterion, order, solver, STARTS).row
        for criterion in CRITERIA
        for order in ORDERS
        for solver in SOLVER_NAMES
    ]
    rows += [study_cell(case, "D", 5, solver, MANY).row for solver in ("ipopt", "sqp")]
    columns = ("criterion", "order", "solver", "converged", "iterations", "time", "criterion reached")
    title = f"Section 7's study, model 9, period {PERIOD:g} s, {STARTS} starts a cell; wanted of D, 5: 20 of 20"
    print_table(title, columns, rows)


def criteria_rows() -> list[list[str]]:
    """What optimising A, K and N gains over the D-optimal motion, Fourier order 5 from the same starts."""
    case = load_case("hexapod")
    values: dict[str, dict[str, float]] = {}
    for letter in CRITERIA:
        found = search(Request("hexapod", criterion=letter, starts=4), case, SILENT)
        values[letter] = _rated(case, found.motion)
    d = values["D"]
    return [
        ["K: condition of the D-optimal motion over the K-optimal one's", f"{d['K'] / values['K']['K']:.2f}", "1.5"],
        ["N: value of the N-optimal motion over the D-optimal one's", f"{values['N']['N'] / d['N']:.2f}", "1.3"],
        ["A: trace of the A-optimal motion over the D-optimal one's", f"{values['A']['A'] / d['A']:.3f}", "0.95"],
    ]


def _rated(case: Case, motion: object) -> dict[str, float]:
    from identification.criteria import singular_values
    from identification.model import identification_model
    from identification.reference import reference_scaling
    from planner.problem import mean_information

    model = identification_model(case, 9)
    mu = singular_values(mean_information(model, reference_scaling(case, model), motion), model.names)  # type: ignore[arg-type]
    return {letter: criterion.of(mu) for letter, criterion in CRITERIA.items()}
