"""Values that contradict each other: which, beside which others, and the unit in which they would fit.

A figure of some values (a time, a length, a share) that no machine has is a contradiction. A value is accused where it
fits its neighbours in another unit: each unit that people mistake is tried on each value, and on all values of one unit
together.
"""

import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from cases.base.errors import Write
from cases.base.phrases import NOTHING, Phrase, as_it_is, enumerated, phrase
from cases.base.places import place_of
from cases.base.units import DEG, Array
from cases.tables import own_units

CONVERTED = "degrees that were taken for radians and converted"
_MISTAKEN = (  # end of a key, and the units that are written there by mistake, with their value in the right one
    (r"_mm(_s)?$", (("m", 1e3), ("um", 1e-3))),
    (r"_m_s\d?$", (("mm", 1e-3),)),
    (r"_deg(_s)?$", (("rad", 1.0 / DEG), (CONVERTED, DEG))),
    (r"_rad_s\d$", (("deg", DEG),)),
    (r"_deg_s\d$", (("rad", 1.0 / DEG),)),
    (r"_kg$", (("g", 1e-3), ("t", 1e3))),
    (r"_kg_m2$", (("kg mm^2", 1e-6), ("kg cm^2", 1e-4), ("g m^2", 1e-3))),
    (r"_N$", (("kN", 1e3), ("mN", 1e-3))),
    (r"_Nm$", (("N mm", 1e-3), ("kN m", 1e3))),
    (r"_ms$", (("s", 1e3), ("us", 1e-3))),
    (r"(?<!m)_s$", (("ms", 1e-3),)),
)
COST = 9.0  # what a mistaken unit must explain, in squares of the scatter of relations, to be named
ANOTHER = 3.0  # what it must explain more where it is one of other keys too
DOUBTFUL = 4.0  # times its scatter that a figure is out where no mistaken unit explains it
_LEAST = 1e-300  # above 0
SHOWN = 4  # values of a sentence


class Stated(NamedTuple):
    """A value as the file states it."""

    key: str  # dotted; several keys of one unit with commas
    value: Array  # in the key's unit
    summary: Phrase = NOTHING  # what it is of the keys, where it is not what the file says

    @property
    def si(self) -> Array:
        """The value in SI."""
        return np.asarray(self.value * own_units([self.key])[0], dtype=float)

    @property
    def words(self) -> Phrase:
        """The value as the file says it."""
        return self.of(self.key)

    def of(self, key: str) -> Phrase:
        """The value as one of this key."""
        return phrase("stated", "{key} {how} {value}", key=key, how=self.summary or "=", value=_shown(self.value))

    def corrected(self, factor: float) -> str:
        """What to write instead, where the value is `factor` times as large."""
        if self.summary:
            return phrase("times_that", "{factor} times that", factor=f"{factor:.4g}")
        return f"{self.key.rpartition('.')[2]} = {_shown(self._meant(factor))}"

    def write(self, factor: float) -> Write | None:
        """The same as a key with its value; None of what is a sum of several keys."""
        if self.summary:
            return None
        numbers = [float(f"{number:.12g}") for number in np.ravel(self._meant(factor))]
        return Write(place_of(self.key), numbers[0] if np.ndim(self.value) == 0 else numbers)

    def _meant(self, factor: float) -> Array:
        sizes = np.abs(self.value)
        apart = self.key.startswith("limits.") and sizes.max() > sizes.min() / min(factor, 1.0 / factor) / 3.0
        wrong = sizes * (1 if factor < 1.0 else -1) > np.sqrt(sizes.max() * sizes.min()) * (1 if factor < 1.0 else -1)
        return np.asarray(np.where(wrong, self.value * factor, self.value) if apart else self.value * factor)


class Doubt(Phrase):
    """A sentence on values that are doubtful, and what it says to write, where keys can."""

    writes: tuple[Write, ...] = ()

    @classmethod
    def on(cls, sentence: Phrase, keys: Iterable[str], writes: Iterable[Write] = ()) -> "Doubt":
        """Of values by their keys, as in `Phrase.keys`."""
        doubt = cls(sentence)
        vars(doubt).update(vars(sentence), keys=tuple(keys), writes=tuple(writes))
        return doubt


class Relation(NamedTuple):
    """A figure of some values, where machines have it, and what it says."""

    keys: tuple[str, ...]  # of the values that it follows from, the suspect first
    figure: float
    low: float  # ends between which it is as usual; 0 or infinite where it has none
    high: float
    scatter: float  # factor beyond them that sound machines scatter by
    words: Phrase

    @property
    def distance(self) -> float:
        """How far it is from usual, in the logarithm of its scatter; 0 between the ends."""
        figure = math.log(max(self.figure, _LEAST))
        out = max(math.log(max(self.low, _LEAST)) - figure, figure - math.log(self.high), 0.0)
        return out / math.log(self.scatter)


Values = Mapping[str, Array]


Relations = Callable[[Values], Iterable[Relation]]


class _Hypothesis(NamedTuple):
    """Some values are in another unit than their keys say."""

    unit: str
    factors: Mapping[str, float]  # of the values of some keys

    @property
    def cost(self) -> float:
        """What it must explain: one mistake, or the same one again and again."""
        names = {key.rpartition(".")[2] for key in self.factors}
        return COST + ANOTHER * (len(names) - 1) + math.log(len(self.factors))

    def concerns(self, relation: Relation) -> bool:
        """Whether a figure follows from values that it is about."""
        return not self.factors.keys().isdisjoint(relation.keys)

    def applied(self, values: Values) -> Values:
        """The values as they are if it is true."""
        return {key: value * self.factors.get(key, 1.0) for key, value in values.items()}


def contradictions(stated: Sequence[Stated], relations: Relations) -> Iterator[Doubt]:
    """Sentences on the values behind figures that no machine has, each with the unit in which it would fit.

    A mistaken unit is named where it explains more than it costs to assume one, and more than any other.
    """
    of_key = {value.key: value for value in stated}
    values: Values = {value.key: value.si for value in stated}
    now = list(relations(values))
    hypotheses = list(_hypotheses(of_key)) if _unusual(now) > COST else []
    while (unusual := _unusual(now)) > COST:  # no hypothesis costs less
        fits = [(_left(hypothesis, values, relations) + hypothesis.cost, hypothesis) for hypothesis in hypotheses]
        score, best = min(fits, key=lambda fit: fit[0], default=(math.inf, None))
        if best is None or score >= unusual:
            break
        concerned = [relation for relation in now if best.concerns(relation)]
        words = _accusation(best, of_key, max(concerned, key=lambda relation: relation.distance))
        writes = [of_key[key].write(factor) for key, factor in best.factors.items()]
        whole = tuple(write for write in writes if write is not None)
        yield Doubt.on(words, best.factors, whole if len(whole) == len(writes) else ())
        values = best.applied(values)
        now = list(relations(values))
        hypotheses = [other for other in hypotheses if not set(other.factors) & set(best.factors)]
    for relation in _first_of_each(relation for relation in now if relation.distance > DOUBTFUL):
        first, *others = (of_key[key].words for key in relation.keys)
        if others:
            sentence = phrase(
                "one_is_wrong",
                "{value} beside {others}: {why}; one of them is wrong",
                value=first,
                others=enumerated("comma", others),
                why=relation.words,
            )
        else:
            sentence = phrase("correct_value", "{value}: {why}; correct it", value=first, why=relation.words)
        yield Doubt.on(sentence, relation.keys)


def _left(hypothesis: _Hypothesis, values: Values, relations: Relations) -> float:
    """How unusual all figures are if a hypothesis is true; without limit where it makes one of its own doubtful."""
    after = list(relations(hypothesis.applied(values)))
    if any(relation.distance > DOUBTFUL and hypothesis.concerns(relation) for relation in after):
        return math.inf
    return _unusual(after)


def _unusual(now: Iterable[Relation]) -> float:
    """How far figures are from usual together, in squares of their scatter."""
    return sum(relation.distance**2 for relation in now)


def _hypotheses(stated: Mapping[str, Stated]) -> Iterator[_Hypothesis]:
    """Each value in each unit that is mistaken for its own; then those of a table that end alike, or may be in it."""
    together: dict[tuple[str, str, str], dict[str, float]] = {}
    for key in stated:
        *tables, name = re.sub(r"\[\d+\]", "", key).split(".")
        for unit, factor in _units(key):
            yield _Hypothesis(unit, {key: factor})
            for depth in range(len(tables), 0, -1):
                for alike in (name, ""):
                    together.setdefault((".".join(tables[:depth]), alike, unit), {})[key] = factor
            for other in stated:  # of the same table, such as accelerations and jerks
                if (
                    other != key
                    and other.rpartition(".")[0] == key.rpartition(".")[0]
                    and (unit, factor) in _units(other)
                ):
                    together[(min(key, other), max(key, other), unit)] = {key: factor, other: factor}
    pairs = set[tuple[frozenset[str], str]]()
    for (_, _, unit), factors in together.items():
        if len(factors) > 1 and (frozenset(factors), unit) not in pairs:
            pairs.add((frozenset(factors), unit))
            yield _Hypothesis(unit, factors)


def _units(key: str) -> list[tuple[str, float]]:
    """Units that are mistaken for that of a key, with their values in it."""
    return [unit for pattern, units in _MISTAKEN if re.search(pattern, key) for unit in units]


def _first_of_each(broken: Iterable[Relation]) -> Iterator[Relation]:
    """The worst of the relations about each value."""
    named = set[str]()
    for relation in sorted(broken, key=lambda relation: -relation.distance):
        if named.isdisjoint(relation.keys):
            yield relation
        named |= set(relation.keys)


def _accusation(hypothesis: _Hypothesis, stated: Mapping[str, Stated], relation: Relation) -> Phrase:
    accused = [stated[key] for key in hypothesis.factors]
    values = _listed(accused)
    if others := [stated[key].words for key in relation.keys if key not in hypothesis.factors]:
        values = phrase("beside", "{values} beside {others}", values=values, others=enumerated("comma", others))
    corrected = (value.corrected(hypothesis.factors[value.key]) for value in accused)
    written = {str(text): text if isinstance(text, Phrase) else re.sub(r"\[\d+\]", "", text) for text in corrected}
    keys: Phrase = enumerated("semicolon", [as_it_is(written[text]) for text in sorted(written)[:SHOWN]])
    if len(written) > SHOWN:
        keys = phrase("and_so_on", "{keys} and so on", keys=keys)
    units = [
        _unit_words(hypothesis.unit, ending) for ending in dict.fromkeys(_per_time(value.key) for value in accused)
    ]
    places = {"values": values, "why": relation.words, "units": enumerated("both", units), "keys": keys}
    if len(accused) == 1:
        return phrase("looks_like", "{values}: {why}; looks like {units}: write {keys}", **places)
    return phrase("look_like", "{values}: {why}; look like {units}: write {keys}", **places)


def _unit_words(unit: str, ending: str) -> Phrase | str:
    """The unit that values look like, with the time that it is by."""
    return f"{unit}{ending}" if ending else _UNITS.get(unit, unit)


_UNITS = {
    "m": phrase("unit_m", "metres"),
    "mm": phrase("unit_mm", "millimetres"),
    "um": phrase("unit_um", "micrometres"),
    "rad": phrase("unit_rad", "radians"),
    "deg": phrase("unit_deg", "degrees"),
    "s": phrase("unit_s", "seconds"),
    CONVERTED: phrase("unit_converted", "degrees that were taken for radians and converted"),
}


def _listed(values: Sequence[Stated]) -> Phrase:
    """Values with their keys; those of several entries of a list together."""
    together: dict[tuple[str, ...], list[tuple[str, Stated]]] = {}
    for value in values:
        start, _, rest = value.key.partition("s[")  # an entry of a list of joints or weights
        number, _, end = rest.partition("]") if "." in start and rest[:1].isdigit() else ("", "", "")
        place = (f"{start}s", end) if number else (value.key,)
        together.setdefault((*place, value.summary, _shown(value.value)), []).append((number, value))
    texts = [
        first.of(f"{names[0]}[{', '.join(n for n, _ in of)}]{names[1]}") if number else first.words
        for names, of in together.items()
        for number, first in of[:1]
    ]
    shown = enumerated("semicolon", texts[:SHOWN])
    if len(texts) <= SHOWN:
        return shown
    return phrase("and_more_values", "{values} and {count} more", values=shown, count=len(texts) - SHOWN)


def _per_time(key: str) -> str:
    """What follows a length or an angle in the unit of a key."""
    match = re.search(r"_(?:mm|m|deg|rad)_s(\d?)$", key)
    return "" if match is None else f"/s^{match[1]}" if match[1] else "/s"


def _shown(value: Array) -> str:
    """Numbers as a file may hold them, with four digits."""
    texts = [f"{number:.4g}" for number in np.ravel(value)]
    return texts[0] if np.ndim(value) == 0 or len(texts) == 1 else f"[{', '.join(texts)}]"
