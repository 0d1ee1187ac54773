"""Commands of what was filled in on the page: each field is checked, and becomes an argument of its own."""

import math
import re
from collections.abc import Collection, Mapping, Sequence

from hexcite.page.refusals import Unfit
from hexcite.page.stages import Machine

Fields = Mapping[str, Sequence[str]]
BY_HAND = "manual"  # the family that others are compared with
FAMILIES = ("best", "ptp", "spline", "fourier", BY_HAND, "poses")
EFFORTS: Mapping[str, tuple[str, ...]] = {"quick": ("--seconds", "20"), "minute": ("--seconds", "60"), "thorough": ()}
SPEEDS: Mapping[str, tuple[str, ...]] = {"full": (), "slow": ("--speed", "0.1")}


def field(fields: Fields, name: str, default: str = "") -> str:
    """The text of a field, without blanks around it."""
    return (fields.get(name) or [default])[0].strip()


def chosen(fields: Fields, name: str, among: Collection[str], default: str | None = None) -> str:
    """The choice of a field; raises Unfit where it is none of those that there are."""
    text = field(fields, name, default or "")
    if text not in among:
        raise Unfit("no_choice", place=name, text=text)
    return text


def number(fields: Fields, name: str, low: float, high: float) -> str:
    """A number as typed, with a comma or a point; raises Unfit where it is none, or out of range."""
    text = field(fields, name).replace(",", ".")
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not low <= value <= high:
        raise Unfit("no_number_between", place=name, text=text, low=low, high=high)
    return text


def whole_number(fields: Fields, name: str, low: int, high: int) -> str:
    """A whole number as typed; raises Unfit where it is none, or out of range."""
    text = number(fields, name, low, high)
    if not text.isdecimal():
        raise Unfit("no_whole_number", place=name, text=text)
    return text


def _targets(text: str) -> list[str]:
    """Accuracies as options, of a list behind commas or semicolons; a comma between two digits is a decimal one."""
    parts = re.split(r";|,(?!\d)", text)
    return [re.sub(r"(?<=\d),(?=\d)", ".", part.strip()) for part in parts if part.strip()]


def place(name: str) -> str:
    """A file or folder as an argument, which no option is."""
    return f"./{name}" if name.startswith("-") else name


def plan(machine: Machine, fields: Fields, output: str, results: Collection[str] = ()) -> list[str]:
    """`hexcite plan` or `hexcite poses`; of `results` those that the form says are known."""
    family = chosen(fields, "family", FAMILIES, "best")
    steps = ["--without", "jerk"] if field(fields, "without_jerk") else []
    known = [f"--known={place(name)}" for name in results if name in fields.get("known", ())]
    if family == "poses":
        count = ["--count", number(fields, "count", 1, 1000)] if field(fields, "count") else []
        return ["poses", machine.argument, *count, *known, *steps, "-o", output]
    command = ["plan", machine.argument]
    if family != "best":
        command += ["--family", family]
    if family != BY_HAND:
        command += ["--duration", number(fields, "duration", 0.5, 600)]
        command += EFFORTS[chosen(fields, "effort", EFFORTS, "quick")]
        command += known
        command += [f"--target={text}" for text in _targets(field(fields, "target"))]
        if field(fields, "seed"):
            command += ["--seed", whole_number(fields, "seed", 0, 2**31)]
    controller = field(fields, "controller")
    if family in ("best", "ptp"):
        if controller:
            command += ["--for", chosen(fields, "controller", machine.dialects)]
        command += steps
    return [*command, "-o", output, "--progress"]


def post(fields: Fields, plan_name: str, dialect: str, output: str, ini: str = "") -> list[str]:
    """`hexcite post`, beside the INI file of the machine where one is named."""
    accepted = [f"--accept={name}" for name in fields.get("accept", ())[:50]]
    speed = SPEEDS[chosen(fields, "speed", SPEEDS, "full")]
    return ["post", place(plan_name), "--dialect", dialect, *speed, *accepted, *_ini_option(ini), "-o", output]


_INI = "--ini="


def _ini_option(ini: str) -> list[str]:
    return [f"{_INI}{place(ini)}"] if ini else []


def ini_in(command: Sequence[str]) -> str:
    """The INI file that a command was given; empty where it was given none."""
    return next((word.removeprefix(_INI).removeprefix("./") for word in command if word.startswith(_INI)), "")


def run(machine: Machine, program: str, on: str, output: str, ini: str = "") -> list[str]:
    """`hexcite run`, beside the INI file of the machine where one is named."""
    return ["run", place(program), "--case", machine.argument, "--on", on, *_ini_option(ini), "-o", output]


def look(machine: Machine, recording: Sequence[str], picture: str, write: bool = False) -> list[str]:
    """`hexcite look`, and with `--write` into the case."""
    to = "--write" if write else "--case"
    return ["look", *map(place, recording), to, machine.argument, "-o", picture, "--overwrite"]


def identify(machine: Machine, recording: Sequence[str], output: str) -> list[str]:
    """`hexcite identify`."""
    return ["identify", *map(place, recording), "--case", machine.argument, "-o", output, "--progress"]
