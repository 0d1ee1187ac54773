"""Structured Text for the parser (blark), and what its tree says of names, types and values.

blark takes 25 ms for a statement: long runs of single-operation statements are therefore taken out of the text before
it parses, one of each run stays, and these lines are read by an own, strict grammar.
"""

import re
from typing import Any

from blark import transform as tree

_OPERAND = r"(?:\w+\[\d+\]|u\.\w+|\d+\.\d+(?:E[+-]?\d+)?|\(-\d+\.\d+(?:E[+-]?\d+)?\))"
_SINGLE = re.compile(
    rf"(\w+\[\d+\]) := (-?{_OPERAND}|{_OPERAND} [-+*/] {_OPERAND}|\w+\({_OPERAND}(?:, {_OPERAND})?\));"
)
PLACEHOLDER = 99999
_LONG = 12  # lines; shorter runs go through the parser


def name_of(node: Any) -> str:
    while not isinstance(node, str):
        node = node.variable if hasattr(node, "variable") else node.name
    return str(node).lower()


def kind_of(spec: Any) -> str:
    return str(spec.type)


def shortened(text: str) -> tuple[str, dict[str, list[Any]]]:
    """The text with a placeholder for each long run of single-operation statements, and the runs by unit."""
    lines: list[str] = []
    runs: dict[str, list[Any]] = {}
    unit, run = "", []

    def end() -> None:
        if len(run) >= _LONG:
            source = "\n".join(line.replace(":=", "=").rstrip(";").lower() for line in run)
            runs.setdefault(unit, []).append(compile(source, unit, "exec"))
            lines.append(f"{run[0].split('[')[0]}[{PLACEHOLDER}] := 0.0;")
        else:
            lines.extend(run)
        run.clear()

    for line in text.splitlines():
        if match := re.match(r"FUNCTION(?:_BLOCK)? (\w+)", line):
            unit = match[1].lower()
        if _SINGLE.fullmatch(line):
            run.append(line)
            continue
        end()
        lines.append(line)
    end()
    return "\n".join(lines) + "\n", runs


def is_constant(attributes: Any) -> bool:
    return attributes is not None and "constant" in attributes.name


def elements_of(initial: Any) -> list[Any]:
    """The values of `[a, b, c]`; the parser may understand b, c as a list of its own without brackets."""
    values: list[Any] = []
    for element in initial.elements:
        assert element.count is None
        nested = isinstance(element.element, tree.ArrayInitialization)
        assert not (nested and element.element.brackets)
        values += elements_of(element.element) if nested else [element.element]
    return values
