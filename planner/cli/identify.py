"""`hexcite identify`: parameters with error bars from a recording."""

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, NamedTuple

import typer

from cases.errors import HexciteError
from cases.schema import Case
from cases.units import MM
from identification.estimation.estimators import Method, method
from identification.estimation.priors import Prior
from identification.estimation.selection import symmetric_platform
from identification.model import Model
from identification.parameters import physical_form
from identification.samples import Conditioning, Periodic
from identification.saved_result import biases_of
from planner.cli.console import Json, Overwrite, Stale, print_json, status


def identify(
    recordings: Annotated[
        list[Path],
        typer.Argument(help="One run: a file, several files of it in any order, or a folder of hexcite run."),
    ],
    case: Annotated[
        str | None, typer.Option(help="Built-in name, folder or file; a recording folder knows its own.")
    ] = None,
    model: Annotated[
        int | None, typer.Option(help="Identification model, 0 to 9; by default what the run can carry.")
    ] = None,
    estimator: Annotated[
        str,
        typer.Option(
            help="gauss-markov, robust (gross errors), full (covariance of the channels), consistent "
            "(inertia of a real body) or nonlinear (physical parameters)."
        ),
    ] = "gauss-markov",
    weights: Annotated[
        str | None,
        typer.Option(
            help="W: equal, per_channel or per_unit (from the residuals), stated (from the noise of forces and "
            "accelerations in the case, through the model); by default the case's."
        ),
    ] = None,
    fix: Annotated[
        list[str] | None, typer.Option(help="A known value, taken as exact: m=93.1kg, xC=0mm. Repeatable.")
    ] = None,
    drop: Annotated[
        list[str] | None, typer.Option(help="A parameter to leave out, as if it were zero: k3. Repeatable.")
    ] = None,
    symmetric: Annotated[
        bool, typer.Option("--symmetric", help="Symmetric platform: xC, yC and moments of deviation are zero.")
    ] = False,
    prior: Annotated[list[str] | None, typer.Option(help="An uncertain value: m=33+-0.5kg. Repeatable.")] = None,
    biases: Annotated[
        Path | None,
        typer.Option(
            help="Result of standstills: take the offsets of forces and accelerometer from it, with their uncertainty."
        ),
    ] = None,
    terms: Annotated[str | None, typer.Option(help="Error terms instead of the model's, of K1 to K5: K1,K4.")] = None,
    poses: Annotated[
        Path | None,
        typer.Option(help="Plan of poses: average the run's standstills, which must be those of this plan."),
    ] = None,
    standstills: Annotated[
        bool, typer.Option("--standstills", help="Average the run's standstills, wherever they are.")
    ] = False,
    period: Annotated[
        str | None,
        typer.Option(
            help="A run that repeats itself: average its periods, differentiate and filter by a Fourier series. "
            "auto finds the period, or give it in seconds."
        ),
    ] = None,
    harmonics: Annotated[
        int | None, typer.Option(help="Of that series; by default as many as stand out of the struts' noise.")
    ] = None,
    flexible: Annotated[
        bool,
        typer.Option(
            "--flexible",
            help="The structure yields: estimate its lowest mode with the parameters, behind a low-pass at half of it.",
        ),
    ] = False,
    verify: Annotated[
        Path | None, typer.Option(help="Predict this second run with the parameters of the first.")
    ] = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Folder to write; RECORDING-result by default.")
    ] = None,
    stale: Stale = False,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Identify parameters from a recorded run.

    Standard deviations: `std` by (28), right where noise is white; `std_robust` allows for noise that is not. The
    larger of the two is what to report.
    """
    from cases.files import RESULT, check_folder, output_place
    from identification.formats.text import require_file
    from identification.recording import files_of
    from planner.cli.console import save_with_page
    from planner.cli.shown_result import answer_of_result, show_result, verify_result
    from planner.runs.identifying import Wish, identified_file
    from planner.runs.recorded import StandstillWish, case_of, poses_of_plan

    conditioning = read_conditioning(period, harmonics, flexible)
    if verify is not None:
        require_file(files_of([verify])[0])  # before a result is written
    loaded, changed = case_of(recordings[0], case, stale)
    words = tuple(t.strip() for t in terms.split(",")) if terms else ()
    typed = Typed(estimator, tuple(fix or ()), tuple(drop or ()), symmetric, tuple(prior or ()), weights, biases, stale)
    wish = Wish(
        model,
        lambda model: method_of(typed, model, loaded),
        words,
        conditioning,
        StandstillWish(None if poses is None else poses_of_plan(poses, loaded), standstills),
    )
    folder = output_place(output, Path(f"{recordings[0].resolve().stem}-result"), overwrite)
    check_folder(folder, RESULT, recordings, overwrite)
    with status("identifying", json):
        result = identified_file(recordings, loaded, wish, changed)
        save_with_page(result, RESULT, folder, overwrite)
    answer = answer_of_result(result, folder)
    if not json:
        show_result(answer)
    if verify is not None:
        answer["verify"] = verify_result(verify, loaded, folder, quiet=json)
    if json:
        print_json(answer)


AUTO = "auto"


def read_conditioning(period: str | None, harmonics: int | None, flexible: bool = False) -> Conditioning:
    """The conditioning that options ask for.

    Args:
        period: `auto` or seconds, as typed.
        harmonics: harmonics of the series.
        flexible: whether a structural mode is estimated.

    Raises:
        HexciteError: not understood, or options that do not go together.
    """
    if harmonics is not None and period is None:
        raise HexciteError(f"--harmonics {harmonics}: is for periodic runs; add --period auto or --period SECONDS")
    if harmonics is not None and harmonics < 1:
        raise HexciteError(f"--harmonics {harmonics}: is not a number of harmonics; give 1 or more")
    if flexible and period is not None:
        raise HexciteError("--flexible: lowers the low-pass, which --period does without; leave one of them out")
    if period is None:
        return Conditioning(flexible=flexible)
    return Conditioning(Periodic(None if period == AUTO else _seconds(period), harmonics))


def _seconds(text: str) -> float:
    try:
        value = float(text.removesuffix("s"))
    except ValueError:
        value = math.nan
    if not 0.0 < value < math.inf:
        raise HexciteError(f"--period {text}: is not a period; give auto or seconds, as --period 3")
    return value


_NUMBER = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_VALUE = re.compile(rf"(?P<name>\w+)=(?P<value>{_NUMBER})(?:(?:\+-|±)(?P<std>{_NUMBER}))?\s*(?P<unit>[^0-9\s][^\s]*)?")

# SI unit of a parameter -> what users may write instead, and its SI value.
_UNITS: Mapping[str, Mapping[str, float]] = {
    "kg": {"kg": 1.0, "g": 1e-3, "t": 1e3},
    "m": {"m": 1.0, "mm": MM},
    "kg m": {"kgm": 1.0, "kgmm": MM},
    "kg m^2": {"kgm2": 1.0, "kgmm2": MM**2},
    "N": {"N": 1.0, "kN": 1e3},
    "N m": {"Nm": 1.0, "Nmm": MM},
    "N/m": {"N/m": 1.0, "N/mm": 1.0 / MM},
    "N m/m": {"Nm/m": 1.0, "Nm/mm": 1.0 / MM},
    "N s^2/m": {"Ns2/m": 1.0, "kg": 1.0},
}


def read_values(texts: Sequence[str], units: Mapping[str, str], option: str) -> dict[str, float]:
    """Exact values in SI by name.

    Args:
        units: SI unit of each parameter that may be named.
        option: option that they were given with, for messages.

    Raises:
        HexciteError: not understood, an unknown name, a missing or unknown unit, or a name given twice.
    """
    values: dict[str, float] = {}
    for text in texts:
        name, value, std = _read(text, units, option, f"{option} m=93.1kg")
        if std is not None:
            raise HexciteError(f"{option} {text}: is exact; write an uncertain value as --prior {text}")
        if name in values:
            raise HexciteError(f"{option} {text}: {name} is given twice; give it once")
        values[name] = value
    return values


def read_uncertain(texts: Sequence[str], units: Mapping[str, str], option: str) -> list[tuple[str, float, float]]:
    """Values with standard deviations in SI, as (name, value, std); errors as `read_values`."""
    values = []
    for text in texts:
        name, value, std = _read(text, units, option, f"{option} m=33+-0.5kg")
        if std is None:
            raise HexciteError(f"{option} {text}: has no standard deviation; write it as {option} m=33+-0.5kg")
        values.append((name, value, std))
    return values


def _read(text: str, units: Mapping[str, str], option: str, example: str) -> tuple[str, float, float | None]:
    found = _VALUE.fullmatch(text.strip())
    if found is None:
        raise HexciteError(f"{option} {text}: is not understood; write {example}")
    name = found["name"]
    if name not in units:
        raise HexciteError(f"{option} {text}: {name} is not a parameter here; choose from {', '.join(units)}")
    known = _UNITS[units[name]]
    if found["unit"] not in known:
        problem = "has no unit" if found["unit"] is None else f"unit {found['unit']} does not fit {name}"
        raise HexciteError(f"{option} {text}: {problem}; give {' or '.join(known)}")
    factor = known[found["unit"]]
    return name, float(found["value"]) * factor, None if found["std"] is None else float(found["std"]) * factor


class Typed(NamedTuple):
    """What a user asks of an identification, as typed."""

    estimator: str = "gauss-markov"  # its name
    fix: tuple[str, ...] = ()  # known values
    drop: tuple[str, ...] = ()  # names to leave out
    symmetric: bool = False  # whether the platform is symmetric
    prior: tuple[str, ...] = ()  # uncertain values
    weights: str | None = None  # instead of the case's
    biases: Path | None = None  # result whose offsets are taken
    stale: bool = False  # go on although the case has changed since the biases were identified


def method_of(wish: Typed, model: Model, case: Case) -> Method:
    """The method that a user asks for.

    Raises:
        HexciteError: a value that is not understood, a name that the model does not have, an unknown estimator, a
            result that is none or belongs to another case.
    """
    units = {p.name: p.unit for p in (*model.parameters, *physical_form(model).parameters)}
    known = read_values(wish.fix, units, "--fix")
    if wish.symmetric:
        known = symmetric_platform(model) | known
    priors = [Prior(*values) for values in read_uncertain(wish.prior, units, "--prior")]
    biases = None if wish.biases is None else biases_of(wish.biases, case, wish.stale)
    return method(wish.estimator, known, wish.drop, priors, wish.weights, biases)
