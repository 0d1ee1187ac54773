"""A4 pages of a certificate: what it states, written from top to bottom, in a language."""

import textwrap
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from cases.base.errors import printable
from hexcite.texts import Language, answers, text
from hexcite.texts.by_code import parameter, plain
from hexcite.texts.certificate import WEIGHTS
from identification.texts import legible, parameter_words, std_text, value_text

WIDTH, HEIGHT = 8.27, 11.69  # A4 [inch]
LEFT, RIGHT, TOP, BOTTOM = 0.09, 0.93, 0.945, 0.06  # shares of a page
LINE = 0.0137  # height of a line of text, share of a page
CHARACTERS = 116  # in a line of small text
VALUES = (LEFT, LEFT + 0.55, LEFT + 0.7)  # columns of parameters: name, ends of value and of uncertainty


def pages_of(statement: Mapping[str, Any], title: str) -> Iterator[Any]:
    """Figures of the pages of what a certificate states."""
    sheet = _Sheet(statement["language"])
    _head(sheet, statement, title)
    _object(sheet, statement)
    _method(sheet, statement["method"])
    _parameters(sheet, statement)
    _verdict(sheet, statement["verdict"])
    if statement["warnings"]:
        sheet.heading(sheet.words("warnings"))
        for warning, phrase in zip(statement["warnings"], statement["phrases"], strict=True):
            sheet.paragraph(f"- {warning if sheet.english else plain(phrase, warning)}")
    _chain(sheet, statement)
    for k, figure in enumerate(sheet.figures, 1):
        figure.text(RIGHT, 0.035, sheet.words("page", k=k, count=len(sheet.figures)), fontsize=7.5, ha="right")
        figure.text(LEFT, 0.035, printable(f"{title}, {statement['issued']}"), fontsize=7.5)
        yield figure


def _head(sheet: "_Sheet", statement: Mapping[str, Any], title: str) -> None:
    """Title, machine and verdict."""
    sheet.put([(LEFT, title)], 15.0, "bold")
    sheet.put([(LEFT, statement["machine"]["title"])], 10.0)
    sheet.y -= 0.5 * LINE
    sheet.put([(LEFT, sheet.words("verdict", word=sheet.passed(statement["verdict"]["passed"])))], 11.0, "bold")
    if statement["simulated"]:
        sheet.put([(LEFT, sheet.words("simulated"))], 9.0, "bold")


def _object(sheet: "_Sheet", statement: Mapping[str, Any]) -> None:
    """Who certifies what: laboratory, run, machine."""
    say, machine = sheet.words, statement["machine"]
    sheet.heading(say("object"))
    for key, value in (
        ("issued_by", statement["laboratory"]), ("operator", statement["operator"]), ("issued", statement["issued"]),
        ("recorded", say("by_file", date=statement["recorded"]) if statement["recorded"] else ""),
        ("machine", say("of_setup", case=machine["case"], setup=machine["setup"])),
        ("serial", ", ".join(f"{part} {number}" for part, number in statement["serial_numbers"].items())),
        ("conditions", statement["conditions"]), ("program", statement["program"]),
    ):  # fmt: skip
        sheet.fact(say(key), value)


def _method(sheet: "_Sheet", method: Mapping[str, Any]) -> None:
    """How parameters were estimated."""
    say = sheet.words
    sheet.heading(say("method"))
    assumptions = [say("known", name=name, value=value) for name, value in method["known"].items()]
    assumptions += [say("prior", name=name) for name in method["priors"]]
    of = say("of_standstills" if method["standstills"] else "of_samples")
    figures = {key: method[key] for key in ("model", "samples", "rank", "condition", "s0")}
    weights = say(f"weights_{method['weights']}") if method["weights"] in WEIGHTS else method["weights"]
    sheet.paragraph(say("by", of=of, weights=weights, more="".join(f"; {each}" for each in assumptions), **figures))


def _parameters(sheet: "_Sheet", statement: Mapping[str, Any]) -> None:
    """The parameters with their expanded uncertainties, and what these count."""
    say, language = sheet.words, sheet.language
    sheet.heading(say("parameters", k=statement["coverage_factor"]))
    heads = (text("parameter", language), text("value", language), "U")
    sheet.put([*zip(VALUES, heads, strict=True)], 7.5, "bold", ends=True)
    for name, of_name in statement["parameters"].items():
        scale, unit = legible(of_name["unit"])
        value, expanded = of_name["value"] * scale, of_name["U"] * scale
        sheet.need(1)
        exact = expanded <= 1e-9 * abs(value)
        texts = (
            (f"{value:.6g}", text("given", language)) if exact else (value_text(value, expanded), std_text(expanded))
        )
        words = parameter_words(name) if sheet.english else parameter(name)
        sheet.put([(LEFT, words), *zip(VALUES[1:], texts, strict=True)], ends=True)
        sheet.y += LINE
        sheet.put([(VALUES[2] + 0.015, unit)])
    sheet.y -= 0.4 * LINE
    sheet.paragraph(say("counts", what=", ".join(map(sheet.cause, statement["counted"]))))
    if statement["not_counted"]:
        sheet.paragraph(say("counts_not", what=", ".join(map(sheet.cause, statement["not_counted"]))))


def _verdict(sheet: "_Sheet", verdict: Mapping[str, Any]) -> None:
    """Each check with its value and limit, and what was not judged."""
    sheet.heading(sheet.words("verdicts"))
    for check in verdict["checks"]:
        sheet.need(1)
        bound = "at_least" if "at_least" in check else "at_most"
        limit = text(bound, sheet.language, limit=f"{check[bound]:.3g}")
        judged = check["check"]
        if not sheet.english and check["code"] in answers.CHECKS:
            judged = answers.CHECKS[check["code"]].format(of=parameter(str(check.get("of", ""))))
        words = [sheet.passed(check["passed"]), judged, f"{check['value']:.3g}", limit, check["unit"]]
        first = LEFT + (0.07 if sheet.english else 0.15)
        sheet.put(list(zip((LEFT, first, LEFT + 0.57, LEFT + 0.65, LEFT + 0.79), words, strict=True)))
    phrases = verdict.get("not_judged_phrases") or [None] * len(verdict["not_judged"])  # earlier ones have none
    for reason, entries in zip(verdict["not_judged"], phrases, strict=True):
        sheet.paragraph(sheet.words("not_judged", reason=reason if sheet.english else plain(entries, reason)))


def _chain(sheet: "_Sheet", statement: Mapping[str, Any]) -> None:
    """Fingerprints from the case to the result, and versions of the programs."""
    say, prints = sheet.words, statement["fingerprints"]
    sheet.need(7 + 2 * len(prints["recording"]))
    sheet.heading(say("chain"))
    chain = [(key, prints[key]) for key in ("case", "plan", "program")]
    chain += [("recording", f"{entry['file']}  SHA-256 {entry['sha256']}") for entry in prints["recording"]]
    for key, value in (*chain, ("result", prints["result"])):
        sheet.fact(say(key), value)
    sheet.fact(say("versions"), ", ".join(f"{name} {version}" for name, version in statement["versions"].items()))
    sheet.y -= 0.4 * LINE
    sheet.paragraph(say("verify"))


class _Sheet:
    """Pages that text is written on from top to bottom; a new one where a page is full."""

    def __init__(self, language: Language) -> None:
        from matplotlib.figure import Figure

        self.language, self.english = language, language == "en"
        self._figure: Any = Figure
        self.figures, self.y = list[Any](), 0.0
        self.begin()

    def words(self, key: str, **places: Any) -> str:
        """Words of certificates in the language of the pages."""
        return text(f"c_{key}", self.language, **places)

    def passed(self, passed: bool) -> str:
        """The word for a limit that is kept, or not."""
        return text("pass" if passed else "fail", self.language)

    def cause(self, kind: str) -> str:
        """What a deviation counts, in words."""
        return kind if self.english else answers.CAUSES.get(kind, kind)

    def begin(self) -> None:
        """Begins a page."""
        self.figures.append(self._figure(figsize=(WIDTH, HEIGHT)))
        self.y = TOP

    def need(self, lines: float) -> None:
        """Begins a page where so many lines have no place left."""
        if self.y - lines * LINE < BOTTOM:
            self.begin()

    def put(
        self, cells: Sequence[tuple[float, str]], size: float = 8.0, weight: str = "normal", ends: bool = False
    ) -> None:
        """Writes cells of a line, each at its place from left to right; with `ends`, all but the first end there."""
        for k, (x, words) in enumerate(cells):
            align = "right" if ends and k else "left"
            self.figures[-1].text(
                x, self.y, printable(words).replace("$", r"\$"), fontsize=size, weight=weight, ha=align, va="top"
            )
        self.y -= LINE * max(1.0, size / 8.5)

    def rule(self) -> None:
        """Draws a line across."""
        from matplotlib.lines import Line2D

        at = self.y + 0.15 * LINE
        self.figures[-1].add_artist(Line2D([LEFT, RIGHT], [at, at], color="0.6", linewidth=0.6))
        self.y -= 0.25 * LINE

    def heading(self, text: str) -> None:
        """Writes a heading that stays with what follows."""
        self.need(5)
        self.y -= 0.6 * LINE
        self.put([(LEFT, text)], 9.5, "bold")
        self.rule()

    def fact(self, name: str, value: str) -> None:
        """Writes a name with its value, which may take several lines; nothing where there is no value."""
        if not value:
            return
        for k, line in enumerate(textwrap.wrap(value, 84, break_long_words=True) or [""]):
            self.need(1)
            self.put([*([(LEFT, name)] if k == 0 else []), (LEFT + 0.2, line)])

    def paragraph(self, text: str) -> None:
        """Writes a sentence or several."""
        for line in textwrap.wrap(text, CHARACTERS, break_long_words=True):
            self.need(1)
            self.put([(LEFT, line)])
