"""Options of commands that are made from what the library declares."""

import inspect
from collections.abc import Callable, Collection, Mapping
from typing import Annotated, TypeVar, get_args, get_origin

import typer

from cases.base.errors import as_typed
from cases.base.options import Declared, Option, options_of

Command = TypeVar("Command", bound=Callable[..., None])


def takes(
    *declarations: type, families: Mapping[str, type] | None = None, but: Collection[str] = ()
) -> Callable[[Command], Command]:
    """A command that also has declared options, handed to it as keyword arguments; they stand before `output`,
    or last.

    Its own parameters may be annotated with an `Option` too.

    Args:
        declarations: typed dictionaries or dataclasses, see `planner.options`.
        families: declarations of options that one family alone has, by its name.
        but: names of options that the command line has in another form.
    """
    parameters = [_parameter(each) for kind in declarations for each in options_of(kind) if each.name not in but]
    parameters += [
        _parameter(each, f"{family}: ") for family, kind in (families or {}).items() for each in options_of(kind)
    ]

    def with_options(command: Command) -> Command:
        of_command = [_own(p) for p in inspect.signature(command).parameters.values() if p.kind is not p.VAR_KEYWORD]
        place = next((k for k, parameter in enumerate(of_command) if parameter.name == "output"), len(of_command))
        signature = inspect.Signature([*of_command[:place], *parameters, *of_command[place:]])
        command.__signature__ = signature  # type: ignore[attr-defined]  # where typer looks
        return command

    return with_options


def _parameter(declared: Declared, prefix: str = "") -> inspect.Parameter:
    """An option as a parameter that typer understands."""
    declaration, optional = declared.option, declared.default in (None, {}, ())
    kinds = [kind for kind in get_args(declared.kind) if kind is not type(None)]
    kind = declaration.read_as or (kinds[0] if kinds else declared.kind)
    names = [f"--{declared.flag}"] if declaration.flag or kind is bool else []
    text = " ".join(filter(None, [prefix + as_typed(declaration.meaning), declaration.written]))
    return inspect.Parameter(
        declared.name,
        inspect.Parameter.POSITIONAL_OR_KEYWORD,
        default=None if optional else kind(declared.default),
        annotation=Annotated[kind | None if optional else kind, typer.Option(*names, help=text)],
    )


def _own(parameter: inspect.Parameter) -> inspect.Parameter:
    """A command's own parameter; one that is annotated with an `Option` as one that typer understands."""
    extras = get_args(parameter.annotation)[1:] if get_origin(parameter.annotation) is Annotated else ()
    if not any(isinstance(extra, Option) for extra in extras):
        return parameter
    kind, declaration = get_args(parameter.annotation)[:2]
    declared_parameter = _parameter(Declared(parameter.name, kind, parameter.default, declaration))
    return parameter.replace(annotation=declared_parameter.annotation, default=declared_parameter.default)
