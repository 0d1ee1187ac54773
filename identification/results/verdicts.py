"""Whether a result is accepted: each limit with the value beside it, passed or failed."""

from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from cases.acceptance import Acceptance, LargestDeviations, Reference
from cases.base.errors import Code, HexciteError
from cases.base.phrases import Phrase, again, enumerated, phrase, said
from cases.base.units import MM, as_html
from cases.schema import Case
from identification.estimation.fit import Value
from identification.results.result import Result
from identification.texts import CHECK, aligned, parameter_words

# kinds of `LargestDeviations`: whether a parameter is one, the unit of the key in SI, and its name
_KINDS: Mapping[str, tuple[Callable[[str, str], bool], float, str]] = {
    "mass_kg": (lambda name, unit: name == "m", 1.0, "kg"),
    "centre_of_gravity_mm": (lambda name, unit: name in ("xC", "yC", "zC"), MM, "mm"),
    "inertia_kg_m2": (lambda name, unit: name.startswith("IC"), 1.0, "kg m^2"),
    "offset_N": (lambda name, unit: name.startswith("f_q0") and unit == "N", 1.0, "N"),
    "offset_Nm": (lambda name, unit: name.startswith("f_q0") and unit == "N m", 1.0, "N m"),
}


class Check(NamedTuple):
    """A value beside its limit."""

    name: str  # what is judged, in words
    value: float
    limit: float  # in the same unit
    unit: str
    least: bool = False  # whether the limit is the smallest value, else the largest
    code: str = ""  # what is judged, for programs
    of: str = ""  # its channel or parameter; empty where there is but one

    @property
    def passed(self) -> bool:
        """Whether the value keeps the limit; no number never does."""
        return bool(self.value >= self.limit if self.least else self.value <= self.limit)

    @property
    def words(self) -> Phrase:
        """What is judged, with its code."""
        return again(self.name, {"code": CHECK, "values": {"code": self.code, "of": self.of}})

    @property
    def bound(self) -> Phrase:
        """The limit in words."""
        if self.least:
            return phrase("allowed_least", "at least {limit}", limit=f"{self.limit:.3g}")
        return phrase("allowed_most", "at most {limit}", limit=f"{self.limit:.3g}")

    def to_json(self) -> dict[str, Any]:
        """Entries of an answer."""
        limit = {"at_least" if self.least else "at_most": self.limit}
        about = {"code": self.code} | ({"of": self.of} if self.of else {})
        return {"check": self.name, **about, "passed": self.passed, "value": self.value, **limit, "unit": self.unit}


class Verdict(NamedTuple):
    """Whether a result is accepted.

    >>> hx.accept(hx.Result.load("empty-result"))
    PASS: 3 limits are kept
      verdict  of                                      value  limit        unit
      PASS     warnings that no deviation counts           0  at most 0    -
      PASS     noise of channel 3 over the stated one   1.12  at most 1.5  -
      PASS     mass, difference from nominal            3.56  at most 25   %
    not judged: the run beside its plan: identify it with its plan
    """

    checks: tuple[Check, ...]
    unjudged: tuple[str, ...]  # what could not be judged, with the reason

    @property
    def passed(self) -> bool:
        """Whether every limit is kept."""
        return all(check.passed for check in self.checks)

    @property
    def word(self) -> str:
        """PASS or FAIL."""
        return "PASS" if self.passed else "FAIL"

    def rows(self) -> list[tuple[str, ...]]:
        """Rows of a table, the head first."""
        head = ("verdict", "of", "value", "limit", "unit")
        return [
            head,
            *(
                (
                    "PASS" if check.passed else "FAIL", check.words, f"{check.value:.3g}",
                    check.bound, check.unit or "-",
                )
                for check in self.checks
            ),
        ]  # fmt: skip

    def to_json(self) -> dict[str, Any]:
        """Entries of an answer."""
        return {
            "passed": self.passed,
            "checks": [check.to_json() for check in self.checks],
            "not_judged": list(self.unjudged),
            "not_judged_phrases": [said(reason).to_json() for reason in self.unjudged],
        }

    def __repr__(self) -> str:
        """The verdict, a line for each limit, and what could not be judged."""
        failed = [check.name for check in self.checks if not check.passed]
        words = f": {', '.join(failed)}" if failed else f": {_kept(len(self.checks))}"
        return "\n".join([f"{self.word}{words}", *aligned(*self.rows()), *(f"not judged: {u}" for u in self.unjudged)])

    def _repr_html_(self) -> str:
        return as_html(self)


def _kept(count: int) -> str:
    return "its limit is kept" if count == 1 else f"{count} limits are kept"


def accept(result: Result, case: Case | None = None) -> Verdict:
    """Whether a result keeps the limits that `[accept]` of a case states; without it, those that need no statement.

    >>> hx.accept(hx.Result.load("empty-result")).passed
    True

    Noise is judged beside what `[sensors]` states, the mass beside `[nominal]`, the run beside its plan.

    Args:
        result: the result.
        case: case with the limits; the result's own unless given.

    Raises:
        HexciteError: nothing can be judged.
    """
    case = result.case if case is None else case
    limits = Acceptance() if case.accept is None else case.accept
    every: list[Check | str] = []
    for of in (
        _warnings(result), _noise(result, limits), _mass(result, case, limits), _run(result, limits),
        *(() if limits.deviations is None else (_deviations(result, limits.deviations),)),
        *(() if limits.reference is None else (of_reference(result.parameters, limits.reference),)),
    ):  # fmt: skip
        every += of
    checks = tuple(one for one in every if isinstance(one, Check))
    unjudged = tuple(one for one in every if isinstance(one, str))
    if not checks:
        raise HexciteError(
            place=result.source,
            problem=phrase("not_judged", "cannot be judged: {why}", why=enumerated("semicolon", unjudged)),
            remedy=phrase("state_accept", "state limits in [accept]"),
            code=Code.MISSING,
        )
    return Verdict(checks, unjudged)


def _warnings(result: Result) -> Iterator[Check | str]:
    doubts = sum(finding.doubts_values for finding in result.findings)
    yield Check("warnings that no deviation counts", float(doubts), 0.0, "", code="warnings")


def _noise(result: Result, limits: Acceptance) -> Iterator[Check | str]:
    noise = result.record.channel_noise
    if noise is None or noise.get("stated") is None:
        why = (
            phrase("noise_not_kept", "it was identified before results kept it")
            if noise is None
            else phrase("noise_not_stated", "sensors.force_noise_N states none")
        )
        if noise is None and result.record.pooled is not None:
            why = phrase("noise_of_a_run_not_kept", "a run of the mean was identified before results kept it")
        yield phrase("noise_not_judged", "noise: {why}", why=why)
        return
    by_drives = np.array(noise.get("by_drives", np.zeros(6)), dtype=float)  # of encoders, which is no sensor's fault
    ratios = np.array(noise["measured"], dtype=float) / np.hypot(np.array(noise["stated"], dtype=float), by_drives)
    worst = int(np.argmax(ratios))
    name = f"noise of channel {worst + 1} over the stated one"
    yield Check(name, float(ratios[worst]), limits.noise_times, "", code="noise", of=str(worst + 1))


def _mass(result: Result, case: Case, limits: Acceptance) -> Iterator[Check | str]:
    mass = result.parameters.get("m")
    if mass is None or case.nominal is None:
        if mass is None:
            yield phrase("no_mass_in_model", "mass: the model has none")
        else:
            yield phrase("no_nominal_mass", "mass: [nominal] states none")
    elif result.mounted:
        yield phrase("payload_was_mounted", "mass: a payload was mounted, [nominal] is the machine without it")
    else:
        struts = case.sensor_frame.struts
        expected = case.nominal.mass_kg + (0.0 if struts is None else struts.carried_kg)
        off = 100.0 * abs(mass.value / expected - 1.0)
        yield Check("mass, difference from nominal", off, limits.mass_percent, "%", code="mass")


def _run(result: Result, limits: Acceptance) -> Iterator[Check | str]:
    quantities = {key: value for finding in result.findings for key, value in finding.quantity.items()}
    figures: Mapping[str, Any] | None = quantities.get("as_planned")
    if figures is None:
        yield phrase("no_plan_beside", "the run beside its plan: identify it with its plan")
    else:
        share = 100.0 * float(figures["share_of_path"])
        yield Check("the plan's path in the run", share, limits.path_percent, "%", least=True, code="path")
        if (longer := figures.get("times_longer")) is not None:
            off = 100.0 * abs(float(longer) - 1.0)
            yield Check("duration, difference from plan", off, limits.duration_percent, "%", code="duration")
    if limits.path_error_mm is not None:
        error = None if result.record.run is None else result.record.run.path_error_mm
        if error is None:
            yield phrase("path_error_unknown", "path error: the recording does not say it")
        else:
            yield Check("path error", float(error), limits.path_error_mm, "mm", code="path_error")


def _deviations(result: Result, largest: LargestDeviations) -> Iterator[Check | str]:
    for key, (of_kind, scale, unit) in _KINDS.items():
        limit = getattr(largest, key)
        if limit is None:
            continue
        of = {n: p.reported / scale for n, p in result.parameters.items() if of_kind(n, p.unit)}
        if not of:
            yield phrase("no_such_deviation", "deviations.{key}: the model has no such parameter", key=key)
            continue
        worst = max(of, key=lambda name: of[name])
        yield Check(f"deviation of {parameter_words(worst)}", of[worst], limit, unit, code="deviation", of=worst)


def of_reference(parameters: Mapping[str, Value], reference: Reference) -> Iterator[Check | str]:
    """E_n of each parameter that a reference states: |difference| over the root of both squared U (k = 2)."""
    reference_values: dict[str, tuple[float, float]] = {}
    if reference.mass_kg is not None and reference.mass_U_kg is not None:
        reference_values["m"] = (reference.mass_kg, reference.mass_U_kg)
    if reference.centre_of_gravity_mm is not None and reference.centre_of_gravity_U_mm is not None:
        values = zip(("xC", "yC", "zC"), reference.centre_of_gravity_mm, strict=True)
        reference_values |= {name: (value * MM, reference.centre_of_gravity_U_mm * MM) for name, value in values}
    for name, (value, expanded) in reference_values.items():
        if name not in parameters:
            yield phrase("reference_unknown", "reference of {name}: it is not determined here", name=name)
        else:
            of = parameters[name]
            yield Check(f"E_n of {parameter_words(name)}", en(of, value, expanded), 1.0, "", code="reference", of=name)


def en(of: Value, value: float, expanded: float) -> float:
    r"""E_n of a value beside a reference value with its expanded uncertainty (k = 2), of ISO 13528.

    .. math::
        E_n = \frac{|x - x_\mathrm{ref}|}{\sqrt{U^2 + U_\mathrm{ref}^2}}
    """
    return float(abs(of.value - value) / np.hypot(of.expanded, expanded))
