"""Options, each declared once with its type, its default and what it means: `Annotated[int, Option("Seed.", 0)]`.

Such a type annotates an argument of a function, a field of a dataclass, or an entry of a typed dictionary that holds
the arguments of several functions. Functions and dataclasses get their documentation from it (`documented`), commands
their options (`hexcite/cli/declared.py`), and signatures that show the default take it by `default_of`.
"""

import inspect
from collections.abc import Callable
from dataclasses import MISSING, dataclass, fields, is_dataclass
from textwrap import wrap
from typing import Annotated, Any, NamedTuple, TypeVar, get_args, get_origin, get_type_hints

from cases.base.errors import in_python


@dataclass(frozen=True, slots=True)
class Option:
    """What an option is, beside its name and type.

    Args:
        meaning: a sentence or two; names of options in them are written by `option`.
        default: of an argument; None where the machine or the search decides. A field has its own.
        unit: of its number, as keys of files have it behind the name.
        flag: name on the command line, where that is another.
        written: how the command line writes it, where that is not a value of its type.
        read_as: type that the command line reads then.
        in_python: what its value is in Python beside its type, such as shape and unit.
    """

    meaning: str
    default: Any = None
    unit: str = ""
    flag: str = ""
    written: str = ""
    read_as: Any = None
    in_python: str = ""


class Declared(NamedTuple):
    """An option as it was declared."""

    name: str
    kind: Any  # type of its values
    default: Any
    option: Option

    @property
    def flag(self) -> str:
        """Its name on the command line, without dashes."""
        return self.option.flag or self.name.replace("_", "-")

    @property
    def key(self) -> str:
        """Its key in files, with its unit."""
        return f"{self.name}_{self.option.unit}" if self.option.unit else self.name


def options_of(declaration: type) -> tuple[Declared, ...]:
    """The options that a typed dictionary of arguments, or a dataclass, declares."""
    members = fields(declaration) if is_dataclass(declaration) else ()
    defaults = {field.name: field.default for field in members if field.default is not MISSING}
    hints = get_type_hints(declaration, include_extras=True).items()
    declared = [(name, *get_args(hint)[:2]) for name, hint in hints if get_origin(hint) is Annotated]
    return tuple(Declared(name, kind, defaults.get(name, said.default), said) for name, kind, said in declared)


def default_of(annotated: Any) -> Any:
    """The default of an option that is declared as an annotated type, for a signature that shows it."""
    return next(extra.default for extra in get_args(annotated)[1:] if isinstance(extra, Option))


_KEYWORD = inspect.Parameter.KEYWORD_ONLY

T = TypeVar("T", bound=Callable[..., object])


def documented(*declarations: type) -> Callable[[T], T]:
    """A function or dataclass whose docstring has a line for each option in place of the line `OPTIONS`.

    Options are those of the declarations, after a function's own parameters that are annotated as such; a dataclass
    without declarations shows its own fields. Its signature names them with their plain types, also where they are
    entries of a typed dictionary.
    """
    declared = [each for declaration in declarations for each in options_of(declaration)]

    def with_options(thing: T) -> T:
        lines = inspect.cleandoc(thing.__doc__ or "").splitlines()
        own_options = () if isinstance(thing, type) else _own_options(thing)
        shown = [*own_options, *(declared or (options_of(thing) if isinstance(thing, type) else ()))]
        texts = [line for each in shown for line in _lines(each)]
        thing.__doc__ = "\n".join(new for line in lines for new in (texts if line.strip() == "OPTIONS" else [line]))
        function: Any = thing.__init__ if isinstance(thing, type) else thing  # type: ignore[misc]
        function.__annotations__ = get_type_hints(function)  # without what is said of them
        signature = inspect.signature(function)
        parameters_of_function = [*signature.parameters.values()]
        if any(p.kind is p.VAR_KEYWORD for p in parameters_of_function):
            parameters = [inspect.Parameter(d.name, _KEYWORD, default=d.default, annotation=d.kind) for d in declared]
            parameters_of_function = [*(p for p in parameters_of_function if p.kind is not p.VAR_KEYWORD), *parameters]
            function.__signature__ = signature.replace(parameters=parameters_of_function)
        return thing

    return with_options


def _own_options(function: Callable[..., object]) -> list[Declared]:
    """Parameters of a function that are annotated with an option."""
    hints, parameters = get_type_hints(function, include_extras=True), inspect.signature(function).parameters
    return [
        Declared(name, get_args(hint)[0], parameters[name].default, extra)
        for name, hint in hints.items()
        for extra in get_args(hint)[1:]
        if isinstance(extra, Option)
    ]


def _lines(declared: Declared) -> list[str]:
    """An option among the arguments of a docstring."""
    declaration = declared.option
    unsaid: tuple[Any, ...] = (None, {}, (), False, inspect.Parameter.empty)
    usual = "" if declared.default in unsaid else f"By default {declared.default}."
    parts = (f"{declared.name}: {in_python(declaration.meaning)}", declaration.in_python, usual)
    text = " ".join(part for part in parts if part)
    return wrap(text, 112, initial_indent=" " * 4, subsequent_indent=" " * 8)
