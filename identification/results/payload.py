"""The payload: the rigid body that was added from one identification to another."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.special import chdtri

from cases.base.errors import Code, IdentificationError
from cases.base.phrases import phrase
from cases.base.units import Array, as_html
from cases.schema import Case
from cases.tolerances import BOUNDS
from identification.estimation.fit import Value
from identification.estimation.nearest_body import NearestBody, nearest_body
from identification.finding import Finding, Kind, changed_cases, sentences, warning
from identification.findings.off_case import edited
from identification.findings.told import LeftOpen, Together
from identification.model.blocks import FIRST_MOMENT, INERTIA, MASS, Block
from identification.model.model import Model
from identification.options import FrameName
from identification.results.estimate import physical_values
from identification.results.expected_errors import stated_sizes
from identification.results.frames import Body, mounting_of_both, place_of
from identification.results.result import Result
from identification.texts import parameter_lines

LEVEL = 1e-3  # share of gravity along an axis from which on the payload's place along it is uncertain
UNLIKELY = 1e-3  # chance of so large a misfit of a weight by noise


@dataclass(frozen=True, repr=False)
class Payload:
    """The payload between two results.

    >>> payload = hx.payload(hx.Result.load("empty-result"), hx.Result.load("loaded-result"))
    >>> f"{payload['m'].value:.2f} +- {payload['m'].reported:.2f} {payload['m'].unit}"
    '19.92 +- 0.01 kg'
    """

    # mass, centre of gravity in {P} and inertia about it (where both results have it) [SI]
    parameters: Mapping[str, Value]
    findings: tuple[Finding, ...]
    empty: Result  # the result without it
    loaded: Result  # the result with it
    body: Body | None  # the same in {P} with its covariance; None where not all of its centre of gravity is known

    def __getitem__(self, name: str) -> Value:
        """A physical parameter [SI], as of a result: `payload["m"].value`, `.reported`, `.unit`."""
        return self.parameters[name]

    @property
    def warnings(self) -> tuple[str, ...]:
        """Sentences that people should act on."""
        return sentences(self.findings, "warning")

    def in_frame(self, frame: FrameName) -> Body:
        """The payload in the frame of the sensor, of the robot's flange or tool, or along the axes of {B} at home.

        Raises:
            HexciteError: no such frame.
            CaseError: the case does not state where it is.
            IdentificationError: its centre of gravity is not known as a whole.
        """
        place = place_of(self.case_as_told, frame)
        body = self.whole_body
        both = self._both_told
        if both is None or not place.fixed:
            return body.seen_from(place, self.loaded.mounting_of_body(body.model, not place.fixed))
        places = tuple([result.model.names.index(n) for n in body.model.names] for result in (self.empty, self.loaded))
        return body.seen_from(place, mounting_of_both(self.loaded.case, *both, (places[0], places[1])))

    @property
    def _both_told(self) -> tuple[LeftOpen, LeftOpen] | None:
        """What both runs leave open of the same sizes of their machine; None where they did not both tell them."""
        one, other = self.empty.left_open, self.loaded.left_open
        if one is None or other is None or dict(one.counts) != dict(other.counts):
            return None
        return (one, other) if in_common(self.empty, self.loaded) >= one.counts.keys() else None

    @property
    def whole_body(self) -> Body:
        """The same in {P}; raises IdentificationError where its centre of gravity is not known as a whole."""
        if self.body is None:
            missing = ", ".join(name for name in ("xC", "yC", "zC") if name not in self.parameters)
            raise IdentificationError(
                place=self.source,
                problem=phrase(
                    "payload_open",
                    "{missing} of the payload not determined, so that it can be stated neither in another frame nor as "
                    "a load",
                    missing=missing,
                ),
                remedy=phrase("weigh_it_turned", "weigh it in another orientation too"),
                code=Code.NO_EXCITATION,
            )
        return self.body

    @property
    def physical(self) -> NearestBody | None:
        """The nearest body that can exist; the estimate itself where it can.

        Raises:
            IdentificationError: its centre of gravity is not known as a whole.
        """
        body = self.whole_body
        return nearest_body(body.model, body.values, body.covariance, body.covariance_robust)

    @property
    def case_as_told(self) -> Case:
        """The case of the machine that carries it, off by the sizes that both of its runs tell together."""
        both = self._both_told
        if both is None:
            return self.loaded.case_as_told
        together, keys = Together.of(*both), list(both[0].counts)
        deviations = stated_sizes(self.loaded)
        one, other = (np.concatenate([of.sizes[k] / deviations[k] for k in keys]) for of in (self.empty, self.loaded))
        parts = np.split(together.first @ one + together.second @ other, np.cumsum(list(both[0].counts.values()))[:-1])
        return edited(self.loaded.case, {k: part * deviations[k] for k, part in zip(keys, parts, strict=True)})

    @property
    def source(self) -> str:
        """Its name in messages: that of the result with it."""
        return self.loaded.source

    @property
    def doubts(self) -> tuple[str, ...]:
        """Why its values may be further off than their deviations say: its own warnings, then those of both results."""
        findings = (*self.findings, *self.empty.findings, *self.loaded.findings)
        return tuple(dict.fromkeys(finding.coded_sentence for finding in findings if finding.doubts_values))

    def to_json(self) -> dict[str, Any]:
        """Entries for programs: parameters, warnings, and the two results that it was computed from."""
        return {
            "parameters": {name: value._asdict() for name, value in self.parameters.items()},
            "warnings": list(self.warnings),
            "doubts": list(self.doubts),
            "computed_from": {
                name: {
                    "result": of.source,
                    "sha256": of.fingerprint,
                    "case": of.case.name,
                    "case_hash": of.record.case_hash,
                    "model": of.record.model,
                    "inputs": list(of.record.inputs),
                }
                for name, of in (("without", self.empty), ("with", self.loaded))
            },
        }

    def __repr__(self) -> str:
        """A line for each parameter, its warnings, and those of both results that doubt their values."""
        lines = [f"warning: {warning}" for warning in self.warnings]
        for run, result in (("without", self.empty), ("with", self.loaded)):
            doubts = [finding.sentence for finding in result.findings if finding.doubts_values]
            lines += [f"warning of the run {run} it: {sentence}" for sentence in dict.fromkeys(doubts)]
        return "\n".join(["Payload", *parameter_lines(self.parameters), *lines])

    def _repr_html_(self) -> str:
        return as_html(self)


def payload(before: Result, after: Result) -> Payload:
    """The body that was mounted from one identification to another: mass, centre of gravity, inertia.

    Raises:
        IdentificationError: both are of the same recording, or the difference in mass is not significant.
        FileProblem: parameters of another case.
    """
    require_two(before, after)
    difference = (payload_on_table if before.case.setup == "1a" else payload_between)(before, after)
    return replace(difference, findings=(*difference.findings, *changed_cases(before.remarks + after.remarks)))


def payload_on_table(before: Result, after: Result) -> Payload:
    """The payload that was put on a frame that does not move, from the offsets without and with it (setup 1a).

    Its weight pulls along gravity alone: the component of the centre of gravity along gravity stays unknown, and so do
    all of xC, yC, zC that have a share in it; the warnings name them.

    Raises:
        IdentificationError: the difference in mass is not significant.
    """
    body = replace(after.model, blocks=(MASS, FIRST_MOMENT))
    still = np.zeros((1, 6))
    matrix = body.matrices(np.zeros((1, 3)), np.eye(3)[None], still, still)[0]
    white = np.diag(before.covariance + after.covariance)
    robust = np.diag(before.covariance_robust + after.covariance_robust - common_of(before, after))
    variance = np.maximum(np.maximum(white, robust), np.finfo(float).tiny)
    root = 1.0 / np.sqrt(variance)
    along = np.abs(body.gravity) > LEVEL * np.linalg.norm(body.gravity)
    # The unknown direction stays free, so that the others do not take over its share.
    spread = np.linalg.pinv(matrix * root[:, None], rcond=1e-9) * root
    u = spread @ (after.values - before.values)
    of_u = (spread * variance) @ spread.T
    findings = _about(before, after, float(u[0]), float(of_u[0, 0]))
    residuals = (after.values - before.values - matrix @ u) * root
    if float(residuals @ residuals) > float(chdtri(3, UNLIKELY)):
        sentence = "the change of the forces is not a weight alone: something pushes, or a sensor has drifted"
        findings.append(warning(Kind.MODEL, sentence))
    names = [n for n, a in zip(("xC", "yC", "zC"), along, strict=True) if a]
    sentence = f"{', '.join(names)} not determined: gravity acts along it, and the frame does not move; weigh the "
    findings.append(warning(Kind.MODEL, f"{sentence}payload in another orientation"))
    physical = physical_values(body, u, of_u, of_u)
    values = {name: value for name, value in physical.items() if name not in names}
    return Payload(values, tuple(findings), before, after, None)


def common_of(
    before: Result, after: Result, old: Sequence[int] | None = None, new: Sequence[int] | None = None
) -> Array:
    """What the difference of two results has less variance by, for both are off by the same tolerances, shape (u, u).

    Args:
        before: one result.
        after: the other one; where its tolerances are others, they have nothing in common.
        old: places of parameters in u of `before`; all of them unless given.
        new: the same of `after`.
    """
    one, other = (slice(None) if places is None else list(places) for places in (old, new))
    size = len(before.values[one])
    both = in_common(before, after)
    cross = np.zeros((size, size))
    for key in both:
        there, here = before.biases[key][one], after.biases[key][other]
        if there.shape[1] == here.shape[1]:
            cross += here @ there.T
    return np.asarray(cross + cross.T)


def in_common(before: Result, after: Result) -> set[str]:
    """Keys of tolerances that both results are off by alike; what is known of the body is of another body."""
    if not _same_tolerances(before, after):
        return set()
    return (before.biases.keys() & after.biases.keys()) - {BOUNDS}


def _same_tolerances(before: Result, after: Result) -> bool:
    """Whether two results count the same tolerances."""
    one, other = (
        {key: value for key, value in (of.record.computed_from or {}).items() if key.startswith("tolerances")}
        for of in (before, after)
    )
    return one == other


def require_two(before: Result, after: Result) -> None:
    """Refuses one recording as both.

    Raises:
        IdentificationError: both results are of the same files.
    """
    # Runs that were never saved have no files; they may have one name, but no two have the same figures.
    files = before.recordings and after.recordings
    if (before.recordings == after.recordings) if files else (before.fingerprint == after.fingerprint):
        raise IdentificationError(
            place=after.source,
            problem=phrase("same_recording", "is of the same recording as {other}", other=before.source),
            remedy=phrase("before_then_after", "name the result of a run without the payload, then of one with it"),
            code=Code.OTHER_SOURCE,
        )


def _about(before: Result, after: Result, mass: float, variance: float) -> list[Finding]:
    """What to say of two results that differ by a mass; raises IdentificationError where it is not significant."""
    std = float(np.sqrt(variance))
    if not abs(mass) > 3.0 * std:
        raise IdentificationError(
            place=after.source,
            problem=phrase(
                "no_payload",
                "mass differs from {other} by {mass} +- {std} kg, not by a payload",
                other=before.source,
                mass=f"{mass:.4g}",
                std=f"{std:.2g}",
            ),
            remedy=phrase("without_then_with", "name the results without and with payload, in this order"),
            code=Code.MISFIT,
        )
    findings = []
    if before.model.number != after.model.number:
        numbers = f"{before.model.number} and {after.model.number}"
        findings.append(warning(Kind.MODEL, f"models {numbers} differ: masses of different models do not compare"))
    if before.record.computed_from != after.record.computed_from:
        findings.append(warning(Kind.CASE, "the case was changed between the two identifications"))
    if mass < 0.0:
        sentence = "the mass became smaller: this is what was taken off, as a negative payload"
        findings.append(warning(Kind.MODEL, sentence))
    return findings


def payload_between(before: Result, after: Result) -> Payload:
    """The body that has to be added to `before` to get `after`; the two runs are independent.

    Mass, first moments and inertia about the origin of {P} of rigid bodies add, so their differences are those of the
    payload, and covariances add, but for the tolerances that both results are off by. What two different models blame
    on mass differs (section 5): then a warning says so.

    Raises:
        IdentificationError: the difference in mass is not significant, so that there is no centre of gravity.
    """
    model_before, model_after = before.model, after.model
    shared: tuple[Block, ...] = (MASS, FIRST_MOMENT)
    if INERTIA in model_before.blocks and INERTIA in model_after.blocks:
        shared = (*shared, INERTIA)
    body = Model(model_after.number, shared, model_after.structure, model_after.gravity)
    old = [model_before.names.index(name) for name in body.names]
    new = [model_after.names.index(name) for name in body.names]
    difference = after.values[new] - before.values[old]
    covariance = after.covariance[np.ix_(new, new)] + before.covariance[np.ix_(old, old)]
    robust = after.covariance_robust[np.ix_(new, new)] + before.covariance_robust[np.ix_(old, old)]
    robust -= common_of(before, after, old, new)
    findings = _about(before, after, float(difference[0]), max(float(covariance[0, 0]), float(robust[0, 0])))
    place, biases = place_of(after.case_as_told, "sensor"), _biases_of(before, after, old, new)
    payload_body = Body(place, body, difference, covariance, robust, biases)
    return Payload(payload_body.parameters, tuple(findings), before, after, payload_body)


def _biases_of(before: Result, after: Result, old: Sequence[int], new: Sequence[int]) -> dict[str, Array]:
    """What tolerances do to the difference of two results, by their keys; none where their parts do not add up.

    They do where both are off by the same sizes; else there are two machines, and the covariance alone says it.
    """
    keys = in_common(before, after)
    if keys != after.biases.keys() - {BOUNDS} or keys != before.biases.keys() - {BOUNDS}:
        return {}
    pairs = {key: (before.biases[key][list(old)], after.biases[key][list(new)]) for key in after.biases if key in keys}
    if any(there.shape != here.shape for there, here in pairs.values()):
        return {}
    return {key: here - there for key, (there, here) in pairs.items()}
