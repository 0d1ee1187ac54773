"""Compiles what was written: gcc for C, LinuxCNC's halcompile for HAL components."""

import shutil
import subprocess
from pathlib import Path

from cases.errors import ExecutionError

SYSTEM_PATH = "/usr/bin:/bin:/usr/sbin:/sbin"
"""Where compilers are looked for: halcompile belongs to the system's Python, not to ours."""

STRICT = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-O2")
TIME_LIMIT = 120.0  # [s]; it takes one


def tool_missing(program: str, packages: str) -> str | None:
    """Why a compiler cannot be run, with the remedy; None if it can."""
    if shutil.which(program, path=SYSTEM_PATH) is None:
        return f"{program} is missing; install {packages}, or export without --build"
    return None


def halcompile_missing() -> str | None:
    """Why HAL components cannot be compiled, with the remedy; None if they can."""
    for program, packages in (
        ("halcompile", "the package linuxcnc-uspace-dev"),
        ("gcc", "the packages gcc and libc6-dev"),
        ("make", "the package make"),
    ):
        if (missing := tool_missing(program, packages)) is not None:
            return missing
    return None


def build_object(source: Path) -> Path:
    """Compiles a C file to an object file beside it.

    Raises:
        ExecutionError: gcc is missing or refuses the file.
    """
    if (missing := tool_missing("gcc", "the packages gcc and libc6-dev")) is not None:
        raise ExecutionError(f"{source.name}: cannot be compiled: {missing}")
    target = source.with_suffix(".o")
    _run(["gcc", *STRICT, "-c", "-o", target.name, source.name], source)
    return target


def build_component(source: Path) -> Path:
    """Compiles a HAL component to a realtime module beside it.

    Raises:
        ExecutionError: halcompile is missing or refuses the file.
    """
    if (missing := halcompile_missing()) is not None:
        raise ExecutionError(f"{source.name}: cannot be compiled: {missing}")
    _run(["halcompile", "--compile", source.name], source)
    return source.with_suffix(".so")


def _run(command: list[str], source: Path) -> None:
    try:
        done = subprocess.run(
            command,
            cwd=source.parent,
            env={"PATH": SYSTEM_PATH, "LC_ALL": "C"},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=TIME_LIMIT,
        )
    except subprocess.TimeoutExpired as error:
        raise ExecutionError(f"{source.name}: {command[0]} did not end within {TIME_LIMIT:g} s; report this") from error
    if done.returncode != 0:
        lines = (done.stderr or done.stdout).strip().splitlines()
        said = next((line for line in lines if "error" in line.lower()), f"exit code {done.returncode}")
        raise ExecutionError(f"{source.name}: {command[0]} refuses it ({said.strip()}); check its installation")
