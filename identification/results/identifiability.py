"""Which parameters of a model can be told apart (section 5, Figure 3), before or after anything is measured.

Pearson correlations of the regressor's columns, the R of the QR decomposition of the scaled regressor (26), and what no
run like this can determine: combinations of parameters that change no force.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cases.base.errors import IdentificationError
from cases.base.phrases import Phrase, as_it_is, enumerated, phrase
from cases.base.units import Array, as_html
from cases.schema import Case
from identification.estimation.fit import column_scale, triangle
from identification.model.blocks import MODELS
from identification.model.model import Model, identification_model
from identification.texts import aligned

NEARLY = 0.95  # magnitude of a correlation from which two columns are said to be nearly alike
SHARE = 1e-3  # of a parameter in a combination that changes no force, from which it is part of it
SHOWN = 4  # pairs that are named
MANY = 4  # parameters of one block from which they are named together


@dataclass(frozen=True, slots=True, repr=False)
class Identifiability:
    """What the forces of a motion, or of poses, say about the parameters of a model.

    >>> moving = hx.identifiability(hx.Recording.load("empty"))
    >>> moving.rank, moving.determined, moving.nearly_alike
    (20, True, [])
    """

    model: int  # its number
    names: tuple[str, ...]  # names of the linear parameters, in the order of (17)
    rows: int  # m n, number of forces
    correlation: Array  # Pearson coefficients of the columns, shape (u, u); 0 for a column without variation
    r: Array  # R of the QR decomposition of the scaled regressor (26), shape (u, u), no diagonal element below 0
    singular_values: Array  # singular values of the scaled regressor, descending, shape (u,)
    alike: tuple[tuple[tuple[str, ...], int], ...]  # parameters that cannot be told apart, and by how many combinations

    @property
    def zero(self) -> float:
        """The numerical zero of Figure 3, `m n eps max |R_ii|`."""
        return float(self.rows * np.finfo(float).eps * np.abs(np.diag(self.r)).max())

    @property
    def rank(self) -> int:
        """Number of combinations of parameters that the forces determine."""
        return len(self.names) - sum(count for _, count in self.alike)

    @property
    def determined(self) -> bool:
        """Whether all parameters can be told apart."""
        return not self.alike

    @property
    def condition(self) -> float:
        """Condition mu_1 / mu_u of the scaled regressor; infinite where parameters cannot be told apart."""
        return float(self.singular_values[0] / self.singular_values[-1]) if self.determined else float("inf")

    @property
    def below_zero(self) -> tuple[str, ...]:
        """Parameters with `|R_ii|` below the numerical zero: those before them in (17) make the same forces."""
        return tuple(name for name, r in zip(self.names, np.abs(np.diag(self.r)), strict=True) if r < self.zero)

    def strongest(self, count: int = 5) -> list[tuple[str, str, float]]:
        """The pairs of parameters with the largest correlation, the largest first."""
        upper = np.triu(np.abs(self.correlation), 1)
        places = [np.unravel_index(int(k), upper.shape) for k in np.argsort(-upper, axis=None)[:count]]
        return [(self.names[i], self.names[j], float(self.correlation[i, j])) for i, j in places if upper[i, j] > 0.0]

    @property
    def nearly_alike(self) -> list[tuple[str, str, float]]:
        """Pairs that can be told apart, but hardly, with their correlation."""
        hidden = {name for names, _ in self.alike for name in names}
        pairs = self.strongest(len(self.names))
        return [p for p in pairs if abs(p[2]) >= NEARLY and not {*p[:2]} <= hidden]

    @property
    def sentences(self) -> tuple[Phrase, ...]:
        """What cannot be told apart, and what hardly can, in words; none where all can."""
        sentences = []
        for names, count in self.alike:
            listed = together(names)
            if len(names) == count == 1:
                sentences.append(phrase("changes_nothing", "{name} changes no force here", name=listed))
            elif len(names) == count:
                sentences.append(phrase("change_nothing", "{names} change no force here", names=listed))
            elif count == 1:
                one = "{names} cannot be told apart: a combination of them changes no force"
                sentences.append(phrase("not_apart", one, names=listed))
            else:
                apart = "{names} cannot be told apart: {count} combinations of them change no force"
                sentences.append(phrase("not_apart_by", apart, names=listed, count=count))
        if pairs := self.nearly_alike:
            first = enumerated("comma", [_pair(*pair) for pair in pairs[:SHOWN]])
            if len(pairs) > SHOWN:
                first = phrase("pairs_more", "{pairs} and {count} more pairs", pairs=first, count=len(pairs) - SHOWN)
            alike = "nearly alike, and so known closely only together: {pairs}"
            sentences.append(phrase("nearly_alike", alike, pairs=first))
        return tuple(sentences)

    @property
    def words(self) -> str:
        """The sentences as one; that all can be told apart where there are none."""
        if self.sentences:
            return "; ".join(self.sentences)
        return f"all {len(self.names)} parameters can be told apart"

    def to_json(self) -> dict[str, Any]:
        """Its entries for programs."""
        return {
            "model": self.model,
            "parameters": list(self.names),
            "rank": self.rank,
            "condition": self.condition if self.determined else None,
            "numerical_zero": self.zero,
            "r_diagonal": np.diag(self.r).tolist(),
            "below_numerical_zero": list(self.below_zero),
            "not_told_apart": [{"parameters": list(names), "combinations": count} for names, count in self.alike],
            "nearly_alike": [{"parameters": [a, b], "correlation": value} for a, b, value in self.nearly_alike],
            "sentences": list(self.sentences),
        }

    def __repr__(self) -> str:
        """Rank and condition, and what cannot be told apart."""
        condition = f", condition {self.condition:.3g}" if self.determined else ""
        return "\n".join(
            [f"Identifiability of model {self.model}: rank {self.rank} of {len(self.names)}{condition}", self.words]
        )

    def __str__(self) -> str:
        """The same with the diagonal of R and the strongest correlation of each parameter."""
        size = np.abs(self.correlation) - np.eye(len(self.names))
        rows = [
            (
                name,
                f"{r:.2g}{' (zero)' if r < self.zero else ''}",
                f"{self.correlation[k, other]:+.3f}",
                self.names[other],
            )
            for k, (name, r) in enumerate(zip(self.names, np.abs(np.diag(self.r)), strict=True))
            for other in [int(size[k].argmax())]
        ]
        table = aligned(("parameter", "|R_ii|", "strongest correlation", "with"), *rows)
        return "\n".join([repr(self), "", *table, f"numerical zero {self.zero:.2g}"])

    _repr_html_ = as_html


def _pair(one: str, other: str, correlation: float) -> Phrase:
    return phrase("pair_correlated", "{one} and {other} ({value})", one=one, other=other, value=f"{correlation:+.3f}")


def together(names: Sequence[str]) -> Phrase:
    """Names as a list; many of one block as one."""
    stems: dict[str, list[str]] = {}
    for name in names:
        stems.setdefault(name.partition("_")[0] if name.startswith("K") else name, []).append(name)
    parts = [
        part
        for stem, numbers in stems.items()
        for part in (
            [phrase("so_many_of", "{count} of {block}", count=len(numbers), block=stem)]
            if len(numbers) > MANY
            else numbers
        )
    ]
    *first, last = parts
    return enumerated("both", [enumerated("comma", first), last]) if first else as_it_is(last)


def analysed(regressors: Array, names: Sequence[str], number: int) -> Identifiability:
    """What a regressor A_j, shape (n, 6, u), says about the parameters of its columns."""
    matrix = regressors.reshape(-1, regressors.shape[2])
    rows, unknowns = matrix.shape
    both = triangle(np.column_stack([np.ones(rows), matrix]))  # the mean of each column, and what is left of it
    r = triangle(both[:, 1:] * column_scale(both[:, 1:]))
    if len(r) < unknowns:  # fewer forces than parameters
        r = np.vstack([r, np.zeros((unknowns - len(r), unknowns))])
    r = r * np.where(np.diag(r) < 0.0, -1.0, 1.0)[:, None]
    _, singular, directions = np.linalg.svd(r)
    hidden = directions[singular <= rows * np.finfo(float).eps * singular[0]].T  # of no force, shape (u, k)
    varied = both[1:, 1:]
    size = np.linalg.norm(varied, axis=0)
    flat = size <= rows * np.finfo(float).eps * np.linalg.norm(both[:, 1:], axis=0)
    scaled = varied * np.where(flat, 0.0, 1.0 / np.where(flat, 1.0, size))
    correlation = np.clip(scaled.T @ scaled, -1.0, 1.0)
    return Identifiability(
        number, tuple(names), rows, correlation, r, singular, _groups(names, np.asarray(hidden @ hidden.T))
    )  # fmt: skip


def _groups(names: Sequence[str], projector: Array) -> tuple[tuple[tuple[str, ...], int], ...]:
    """Parameters that share combinations without a force, by the projector on these, and the number of combinations."""
    linked, remaining, groups = (
        np.abs(projector) > SHARE,
        set(np.flatnonzero(np.diag(projector) > SHARE**2).tolist()),
        [],
    )
    while remaining:
        group, new = set[int](), {min(remaining)}
        while new:
            group |= new
            new = {int(k) for member in new for k in np.flatnonzero(linked[member])} & remaining - group
        remaining -= group
        members = sorted(group)
        groups.append(
            (tuple(names[k] for k in members), max(1, round(float(np.trace(projector[np.ix_(members, members)])))))
        )
    silent = tuple(name for members, count in groups if len(members) == count for name in members)
    others = tuple(group for group in groups if len(group[0]) > group[1])
    return (*others, (silent, len(silent))) if silent else others


def models_of(case: Case) -> dict[int, Model]:
    """The models that the sensors of a case can have, by their numbers."""
    models = {}
    for number in MODELS:
        try:
            models[number] = identification_model(case, number)
        except IdentificationError:  # it has error terms of other sensors
            continue
    return models


def of_models(models: Mapping[int, Model], regressors: Callable[[Model], Array]) -> tuple[Identifiability, ...]:
    """The analysis of several models of one sensor frame, whose columns are computed together.

    Args:
        models: models by number.
        regressors: what gives A for a model, shape (n, 6, u).
    """
    from dataclasses import replace

    blocks = tuple(dict.fromkeys(block for model in models.values() for block in model.blocks))
    matrices, places, first = regressors(replace(next(iter(models.values())), blocks=blocks)), {}, 0
    for block in blocks:
        places[block] = list(range(first, first + len(block.parameters)))
        first += len(block.parameters)
    return tuple(
        analysed(matrices[:, :, [k for block in model.blocks for k in places[block]]], model.names, number)
        for number, model in models.items()
    )
