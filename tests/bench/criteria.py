"""What each criterion gains over the D-optimal motion of its family, in reference scaling."""

from threading import Event
from typing import Any

from cases.schema import Case, load_case
from identification.estimation.criteria import Criterion, reference_scaling, singular_values
from identification.model.model import identification_model
from identification.motion.motion import Trajectory
from planner.bounds.bound import information_limit
from planner.families.settings import family_class
from planner.noise import mean_information
from planner.plans.making import search
from planner.request import Request
from planner.search.parallel import silent, workers
from tests.bench.tables import print_table

MODEL = 9
FREE: dict[str, Any] = {"free_order": True, "free_period": True}
LOOKED_AT: tuple[tuple[str, dict[str, Any]], ...] = (  # family, its settings
    ("fourier", {}),
    ("fourier", FREE),
    ("ptp", {}),
    ("spline", {}),
)
WANTED = {"A": "trace 5 % lower", "D": "", "K": "1.50 times smaller", "N": "1.30 times larger"}


def criteria_table() -> None:
    """Prints all criteria of the motions that are optimal by each of them, and the gains that are wanted.

    Both motions of a gain are what `hexcite plan` finds with the same settings.
    Where order and period are free too, the D-optimal series is conditioned so well that 1.5 times less cannot be
    expected.
    """
    case = load_case("hexapod")
    model = identification_model(case, MODEL)
    bound = information_limit(case, model)
    rows = []
    for family, settings in LOOKED_AT:
        values = {}
        for letter in sorted(Criterion, key=lambda letter: letter != "D"):
            request = Request(family_class(family)(**settings), criterion=letter, model=MODEL)
            with workers(Event()) as run:
                found = search(request, case, silent, run)
            values[letter] = criteria_of(case, found.motion)
            seconds = [start.record.seconds for start in found.starts]
            rows.append(
                [
                    f"{family}{', best order, period' if settings else ''}, {letter}-optimal",
                    f"{-values[letter]['A']:.4g}",
                    f"{bound.efficiency(values[letter]['D']):.3f}",
                    f"{-values[letter]['K']:.4g}",
                    f"{values[letter]['N']:.4g}",
                    gain(letter, values[Criterion(letter)], values[Criterion.D]),
                    WANTED[letter],
                    f"{max(seconds):.0f} s",
                ]
            )
    columns = (
        "motion", "A: trace", "d_efficiency", "K: condition", "N: value", "against D-optimal", "wanted",
        "longest start",
    )  # fmt: skip
    print_table("Criteria of Table 4 on the hexapod, model 9, 12 s, reference scaling", columns, rows)


def gain(letter: str, own: dict[str, float], of_d: dict[str, float]) -> str:
    """What a motion that is optimal by a criterion gains by it over the D-optimal one, worded as what is wanted."""
    ratio = own[letter] / of_d[letter]
    if letter == "A":
        return f"trace {100 * (1 - ratio):.1f} % lower"
    if letter == "K":
        return f"{1 / ratio:.2f} times smaller"
    return f"{ratio:.2f} times larger" if letter == "N" else ""


def criteria_of(case: Case, motion: Trajectory) -> dict[str, float]:
    """Each criterion of a motion, to be maximised."""
    model = identification_model(case, MODEL)
    mu = singular_values(mean_information(model, reference_scaling(case, model), motion), model.names)
    return {letter: letter.of_singular_values(mu) for letter in Criterion}
