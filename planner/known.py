"""What earlier results say of the parameters of a machine, before a run of it is planned."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from cases.base.errors import Code, FileProblem, HexciteError, option
from cases.base.phrases import phrase
from cases.base.units import Array
from cases.basis import changes_since, result_basis
from cases.schema import Case

if TYPE_CHECKING:
    from identification.results.result import Result  # with SciPy, which plans that know nothing do without

SAME_MASS = 1e-6  # [kg]


@dataclass(frozen=True, slots=True, eq=False)
class Known:
    """Linear parameters as results of the same machine with the same load say them."""

    results: tuple[str, ...]  # their names
    model: int  # number in Table 2
    values: Array  # u, shape (u,) [SI]
    covariance: Array  # of u by (28), shape (u, u)
    covariance_robust: Array  # of u with all that deviations count
    biases: Mapping[str, Array]  # part of it by what all runs of the machine have in common, as of a result
    warnings: tuple[str, ...]  # that the results do not agree

    @classmethod
    def of(cls, results: Sequence[object], case: Case, payload: int, standing: bool) -> "Known":
        """What results say together, of several their generalised mean.

        Args:
            case: case that is planned for.
            payload: number of its payloads that will be mounted.
            standing: whether standstills are planned, not a motion.

        Raises:
            FileProblem: one is of another machine, case, load or kind of run, counts what was known otherwise, or two
                cannot be pooled.
        """
        from identification.results.pooling import pool
        from identification.results.result import Result

        earlier = [result for result in results if isinstance(result, Result)]
        if len(earlier) < len(results):
            raise HexciteError(
                place="known",
                problem="holds something that is not a result",
                remedy="give values of hexcite.Result",
                code=Code.WRONG_KIND,
            )
        for result in earlier:
            _require_usable(result, case, payload, standing)
        one = earlier[0] if len(earlier) == 1 else pool(earlier)
        warnings = () if len(earlier) == 1 else tuple(one.warnings)
        names = tuple(str(result.source if result.file is None else result.file.parent) for result in earlier)
        return cls(
            names, one.record.model, one.values, one.covariance, one.covariance_robust, dict(one.biases), warnings
        )

    @property
    def by_noise(self) -> Array:
        """Covariance of u by the noise of the results, which further runs lower, shape (u, u)."""
        from identification.results.pooling import mean_of  # SciPy, which plans that know nothing do without

        return mean_of([self]).random

    def require_model(self, number: int) -> None:
        """Raises HexciteError where a plan is for another model."""
        if number != self.model:
            raise HexciteError(
                problem=phrase(
                    "known_of_model",
                    "{result} has the parameters of model {model}, the plan those of model {number}",
                    result=self.results[0],
                    model=self.model,
                    number=number,
                ),
                remedy=phrase(
                    "plan_with_model",
                    "plan with {option} {model}, or identify with {option} {number}",
                    option=option("model"),
                    model=self.model,
                    number=number,
                ),
                code=Code.OTHER_SOURCE,
            )


def load_known(folders: Sequence[Path], case: Case) -> "list[Result]":
    """The results of folders; errors as of `Result.load`, also where the case has changed since."""
    if not folders:
        return []  # without the half second that loading the type takes
    from identification.results.result import Result

    return [Result.load(folder, case) for folder in folders]


def _require_usable(result: "Result", case: Case, payload: int, standing: bool) -> None:
    """Raises FileProblem where what a result says does not hold for the run that is planned."""
    record, source = result.record, result.source
    if record.case != case.name:
        raise FileProblem(
            place=source,
            problem=f"is of case {record.case}, the plan of {case.name}",
            remedy="name results of this machine",
            code=Code.OTHER_SOURCE,
        )
    if changes := changes_since({"computed_from": record.computed_from}, result_basis(case), case.hash):
        raise FileProblem(
            place=source,
            problem=phrase(
                "known_of_other", "was identified with another case {case}: {change}", case=case.name, change=changes[0]
            ),
            remedy=phrase("identify_with_plan", "identify its recording again with the case of the plan"),
            code=Code.OTHER_SOURCE,
        )
    fixed = [*(record.known or {}), *record.dropped, *(record.priors or {})]
    if fixed:
        raise FileProblem(
            place=source,
            problem=phrase(
                "known_beforehand", "was identified with {name} known, which is not what its run told", name=fixed[0]
            ),
            remedy=phrase(
                "identify_without",
                "identify without {fix}, {drop} and {prior}",
                fix=option("known", "fix"),
                drop=option("dropped", "drop"),
                prior=option("priors", "prior"),
            ),
            code=Code.CONTRADICTION,
        )
    weights = () if case.payloads is None else case.payloads.weights[:payload]
    mass = sum(weight.mass_kg for weight in weights)
    if abs(result.mounted - mass) > SAME_MASS:
        raise FileProblem(
            place=source,
            problem=phrase(
                "other_payload_mounted",
                "a payload of {mounted} kg was mounted, {planned} kg is planned for",
                mounted=f"{result.mounted:.4g}",
                planned=f"{mass:.4g}",
            ),
            remedy=phrase("plan_with_payload", "plan with the {option} of that run", option=option("payload")),
            code=Code.OTHER_SOURCE,
        )
    if (record.delay_s is None) != standing:
        raise FileProblem(
            place=source,
            problem=phrase("known_of_motion", "is of a motion, standstills are planned")
            if standing
            else phrase("known_of_standstills", "is of standstills, a motion is planned"),
            remedy=phrase("same_kind_of_run", "name results of the same kind of run"),
            code=Code.OTHER_SOURCE,
        )
