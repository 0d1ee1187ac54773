"""A small PLC for tests: runs Structured Text as a third party's parser (blark) understands it.

Only what the export uses is known here; all else is an error. Names are case-insensitive, types and array bounds are
checked, constants cannot be written, nothing is initialised silently to anything but zero.
"""

import contextlib
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from blark import transform as tree
from blark.parse import parse_source_code

from tests.postprocessors.export.plc_text import PLACEHOLDER, elements_of, is_constant, kind_of, name_of, shortened

_ZERO = {"LREAL": 0.0, "INT": 0, "DINT": 0, "BOOL": False}
_PYTHON = {"LREAL": float, "INT": int, "DINT": int, "BOOL": bool}
_RANGE = {"INT": 2**15, "DINT": 2**31}
_MATH: dict[str, Callable[[Any], Any]] = {
    "sin": math.sin,
    "cos": math.cos,
    "sqrt": math.sqrt,
    "atan": math.atan,
    "abs": abs,
    "dint_to_lreal": float,
}


class _Return(Exception):
    """RETURN."""


@dataclass
class Cell:
    """A variable: its type, value, and whether it may be written. Arrays are lists, structures dicts of cells."""

    kind: str
    value: Any
    constant: bool = False

    def write(self, value: Any) -> None:
        assert not self.constant, "a constant was written"
        if self.kind == "LREAL" and type(value) is int:
            value = float(value)
        if self.kind in _PYTHON:
            assert type(value) is _PYTHON[self.kind], f"{value!r} is no {self.kind}"
        if self.kind in _RANGE:
            assert -_RANGE[self.kind] <= value < _RANGE[self.kind], f"{value} overflows {self.kind}"
        self.value = value


Scope = dict[str, Cell]


@dataclass
class Unit:
    """A function or function block.

    Args:
        name: as declared, lower case.
        result: type of a function's result.
        sections: declarations, by section in their order.
        body: its statements.
        runs: for placeholders, the statements that they stand for.
    """

    name: str
    result: str | None
    sections: list[tuple[str, bool, Any]]
    body: list[Any]
    runs: list[Any]


@dataclass
class Plc:
    """A program that was loaded."""

    structures: dict[str, dict[str, tuple[str, Any]]] = field(default_factory=dict)
    constants: Scope = field(default_factory=dict)
    units: dict[str, Unit] = field(default_factory=dict)
    blocks: dict[str, Scope] = field(default_factory=dict)

    # Loading

    def load(self, text: str) -> "Plc":
        short, runs = shortened(text)
        parsed = parse_source_code(short)
        if parsed.exception is not None:
            raise parsed.exception
        for item in parsed.transform().items:
            self._declare(item, runs)
        return self

    def _declare(self, item: Any, runs: dict[str, list[Any]]) -> None:
        if isinstance(item, tree.DataTypeDeclaration):
            declaration = item.declaration
            fields = {
                name_of(v): (kind_of(d.init.spec), self._value(d.init.value, {}))
                for d in declaration.declarations
                for v in d.variables
            }
            assert len(fields) == len(declaration.declarations), "two names differ in case only"
            self.structures[str(declaration.name).lower()] = fields
        elif isinstance(item, tree.GlobalVariableDeclarations):
            assert is_constant(item.attrs)
            for entry in item.items:
                (name,) = entry.spec.variables
                cell = self._structure(str(entry.init.spec.type).lower())
                for inner in cell.value.values():
                    inner.constant = True
                self.constants[str(name).lower()] = cell
        else:
            assert isinstance(item, tree.Function | tree.FunctionBlock), type(item)
            result = kind_of(item.return_type.type) if isinstance(item, tree.Function) else None
            sections = [(type(d).__name__, is_constant(d.attrs), d.items) for d in item.declarations]
            name = str(item.name).lower()
            self.units[name] = Unit(name, result, sections, item.body.statements, runs.get(name, []))

    def _structure(self, name: str) -> Cell:
        cells = {key: Cell(kind, _ZERO[kind]) for key, (kind, _) in self.structures[name].items()}
        for key, (_, initial) in self.structures[name].items():
            cells[key].write(initial)
        return Cell(name, cells)

    def _fresh(self, declaration: Any) -> list[tuple[str, Cell]]:
        cells = []
        for variable in declaration.variables:
            spec = declaration.init.spec
            initial = declaration.init.value
            if isinstance(spec, tree.ArraySpecification):
                (span,) = spec.subranges
                assert int(span.start.value) == 0
                kind = str(spec.type.type_name)
                cell = Cell(kind + "[]", [_ZERO[kind]] * (int(span.stop.value) + 1))
                if initial is not None:
                    cell.value = [self._value(e, {}) for e in elements_of(initial)]
                    assert len(cell.value) == int(span.stop.value) + 1
            elif str(spec.type) in _ZERO:
                cell = Cell(str(spec.type), _ZERO[str(spec.type)])
                if initial is not None:
                    cell.write(self._value(initial, {}))
            else:
                cell = self._structure(str(spec.type).lower())
                if initial is not None:
                    given = self.constants[str(initial.name).lower()]
                    assert given.kind == cell.kind
                    for key, inner in given.value.items():
                        cell.value[key].write(inner.value)
            cells.append((name_of(variable), cell))
        return cells

    # Running

    def block(self, name: str) -> Scope:
        """The memory of a new instance of a function block."""
        scope: Scope = {}
        for section, constant, items in self.units[name.lower()].sections:
            assert section in ("InputDeclarations", "OutputDeclarations", "VariableDeclarations"), section
            for declaration in items:
                for key, cell in self._fresh(declaration):
                    cell.constant = constant
                    assert key not in scope, f"{key} is declared twice"
                    scope[key] = cell
        return scope

    def cycle(self, name: str, scope: Scope, **inputs: Any) -> None:
        """One call of a function block."""
        for key, value in inputs.items():
            cell = scope[key.lower()]
            if cell.kind.endswith("[]"):
                assert len(value) == len(cell.value)
                cell.value = [float(v) for v in value]
            else:
                cell.write(value)
        self._run(self.units[name.lower()], scope)

    def function(self, name: str, shared: Scope, **inputs: int) -> Any:
        """Calls a function: variables that it shares, and values."""

        def argument(key: str, value: Any) -> Any:
            return tree.InputParameterAssignment(tree.SimpleVariable(key, False), value)

        arguments = [argument(key, tree.SimpleVariable(key, False)) for key in shared]
        arguments += [argument(key, tree.Integer(str(value), None)) for key, value in inputs.items()]
        return self._call(name.lower(), arguments, shared)

    def _run(self, unit: Unit, scope: Scope) -> None:
        with contextlib.suppress(_Return):
            self._statements(unit.body, scope, list(unit.runs))

    def _call(self, name: str, arguments: list[Any], scope: Scope) -> Any:
        if name in _MATH:
            (argument,) = arguments
            return _MATH[name](self._value(argument.value, scope))
        unit = self.units[name]
        assert unit.result is not None
        inner: Scope = {name: Cell(unit.result, _ZERO[unit.result])}
        named = {name_of(a): a.value for a in arguments if a.name is not None}
        plain = [a.value for a in arguments if a.name is None]
        for section, constant, items in unit.sections:
            for declaration in items:
                for key, cell in self._fresh(declaration):
                    assert key not in inner, f"{key} is declared twice"
                    if section == "InputOutputDeclarations":
                        given = self._cell(named.pop(key), scope)
                        assert given.kind == cell.kind
                        assert not isinstance(cell.value, list) or len(given.value) == len(cell.value)
                        assert not given.constant
                        cell = given
                    elif section == "InputDeclarations":
                        cell.write(self._value(named.pop(key) if key in named else plain.pop(0), scope))
                    else:
                        cell.constant = constant
                    inner[key] = cell
        assert not named, f"{name} has no {', '.join(named)}"
        assert not plain
        self._run(unit, inner)
        return inner[name].value

    def _cell(self, node: Any, scope: Scope) -> Cell:
        assert isinstance(node, tree.SimpleVariable), node
        name = str(node.name).lower()
        return scope[name] if name in scope else self.constants[name]

    def _statements(self, statements: list[Any], scope: Scope, runs: list[Any]) -> None:
        for statement in statements:
            if isinstance(statement, tree.AssignmentStatement):
                (target,) = statement.variables
                if str(target).endswith(f"[{PLACEHOLDER}]"):
                    self._straight(runs.pop(0), scope)
                    continue
                self._assign(target, self._value(statement.expression, scope), scope)
            elif isinstance(statement, tree.IfStatement):
                branches = [(statement.if_expression, statement.statements)]
                branches += [(e.if_expression, e.statements) for e in statement.else_ifs]
                for condition, then in branches:
                    chosen = self._value(condition, scope)
                    assert type(chosen) is bool
                    if chosen:
                        self._statements(then.statements, scope, runs)
                        break
                else:
                    if statement.else_clause is not None:
                        self._statements(statement.else_clause.statements.statements, scope, runs)
            elif isinstance(statement, tree.ForStatement):
                control = self._cell(statement.control, scope)
                first, last = (self._value(v, scope) for v in (statement.from_, statement.to))
                by = 1 if statement.step is None else self._value(statement.step, scope)
                control.write(first)
                while control.value <= last if by > 0 else control.value >= last:
                    self._statements(statement.statements.statements, scope, runs)
                    control.write(control.value + by)
            else:
                assert isinstance(statement, tree.ReturnStatement), statement
                raise _Return

    def _straight(self, code: Any, scope: Scope) -> None:
        names = {key: cell.value for key, cell in scope.items() if cell.kind.endswith("[]")}
        if "u" in scope:
            names["u"] = type("U", (), {key: cell.value for key, cell in scope["u"].value.items()})
        functions = {n: _MATH[n] for n in ("sin", "cos", "sqrt")}
        functions |= {n: self._function(n) for n in self.units if n.endswith("atan2")}
        exec(code, {"__builtins__": {}} | functions | names)

    def _function(self, name: str) -> Any:
        def function(*values: float) -> Any:
            arguments = [tree.InputParameterAssignment(None, tree.Real(str(v), None)) for v in values]
            return self._call(name, arguments, {})

        return function

    def _assign(self, target: Any, value: Any, scope: Scope) -> None:
        if isinstance(target, tree.SimpleVariable):
            cell = self._cell(target, scope)
            assert not isinstance(cell.value, list | dict)
            cell.write(value)
            return
        cell = self._cell(target.name, scope)
        (element,) = target.elements
        if isinstance(element, tree.FieldSelector):
            cell.value[str(element.field.name).lower()].write(value)
            return
        assert not cell.constant
        one = Cell(cell.kind[:-2], None)
        one.write(value)
        cell.value[self._index(element, cell, scope)] = one.value

    def _index(self, element: Any, cell: Cell, scope: Scope) -> int:
        (subscript,) = element.subscripts
        index = self._value(subscript, scope)
        assert type(index) is int
        assert 0 <= index < len(cell.value), f"index {index}"
        return index

    def _value(self, node: Any, scope: Scope) -> Any:
        match node:
            case tree.Real():
                return float(str(node.value))
            case tree.Integer():
                return int(str(node.value))
            case tree.Boolean():
                return str(node.value) == "TRUE"
            case tree.ParenthesizedExpression():
                return self._value(node.expr, scope)
            case tree.SimpleVariable():
                cell = self._cell(node, scope)
                assert not isinstance(cell.value, list | dict)
                return cell.value
            case tree.MultiElementVariable():
                cell = self._cell(node.name, scope)
                (element,) = node.elements
                if isinstance(element, tree.FieldSelector):
                    return cell.value[str(element.field.name).lower()].value
                return cell.value[self._index(element, cell, scope)]
            case tree.FunctionCall():
                return self._call(str(node.name.name).lower(), node.parameters, scope)
            case tree.UnaryOperation():
                value = self._value(node.expr, scope)
                if str(node.op) == "NOT":
                    assert type(value) is bool
                    return not value
                assert str(node.op) == "-"
                return -value
            case tree.BinaryOperation():
                return self._binary(str(node.op).upper(), self._value(node.left, scope), self._value(node.right, scope))
        raise AssertionError(f"{type(node).__name__} is not known")

    @staticmethod
    def _binary(operator: str, left: Any, right: Any) -> Any:
        if operator in ("AND", "OR"):
            assert type(left) is type(right) is bool
            return left and right if operator == "AND" else left or right
        assert bool not in (type(left), type(right))
        if operator == "/":
            assert float in (type(left), type(right)), "an integer division cuts"
            return left / right
        operations = {
            "+": lambda: left + right,
            "-": lambda: left - right,
            "*": lambda: left * right,
            "<": lambda: left < right,
            ">": lambda: left > right,
            "<=": lambda: left <= right,
            ">=": lambda: left >= right,
            "=": lambda: left == right,
        }
        return operations[operator]()
