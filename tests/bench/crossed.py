"""How many of hexcite's files a command runs through, beside what is wanted.

python tests/bench/crossed.py

Each command runs in a process of its own, on the built-in hexapod. A file counts where one of its functions is called;
what Python does when it imports a module does not.
"""

import json
import subprocess
import sys
from collections.abc import Callable
from importlib import import_module
from inspect import CO_OPTIMIZED
from pathlib import Path
from tempfile import TemporaryDirectory
from types import CodeType

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT))  # started as a script: tests is not an installed package

PACKAGES = ("cases", "identification", "planner", "postprocessors")
COLUMNS = ("command", "files", "at most", "functions")
WANTED = {"identify": 45, "identify from Python": 30, "plan, then post": 60}


def crossed(listed: bool = False) -> list[list[str]]:
    """Rows of the table; `listed`: prints the names of the files, too."""
    with TemporaryDirectory() as name:
        plan, program, run, result = (f"{name}/{part}" for part in ("plan", "program.ngc", "run", "result"))
        accept = ("--accept", "jerk,acceleration,strut-velocity,strut-acceleration,sensor-force")
        short = ("--moves", "12", "--duration", "4", "--starts", "1", "--for", "linuxcnc", "--without", "jerk")
        planned = _traced("plan", "hexapod", *short, "-o", plan)
        written = _traced("post", plan, *accept, "-o", program)
        _traced("run", program, "--case", "hexapod", "--on", "virtual", "-o", run)
        found = {
            "identify": _traced("identify", run, "-o", result),
            "identify from Python": _traced("python", run),
            "plan, then post": planned | written,
        }
    for what, places in found.items() if listed else ():
        print(what, *sorted({file for file, _ in places}), sep="\n  ")
    return [
        [what, f"{len({file for file, _ in places})}", f"{WANTED[what]}", f"{len(places)}"]
        for what, places in found.items()
    ]


def _traced(*arguments: str) -> set[tuple[str, str]]:
    """Files and functions through which a command ran, in a process of its own."""
    answer = subprocess.run([sys.executable, __file__, *arguments], capture_output=True, text=True, cwd=ROOT)
    if answer.returncode != 0:
        raise RuntimeError(answer.stderr)
    return {(file, name) for file, name in json.loads(answer.stdout.splitlines()[-1])}


def _trace(call: Callable[[], object]) -> set[tuple[str, str]]:
    codes: set[CodeType] = set()
    sys.setprofile(lambda frame, *_: codes.add(frame.f_code))
    try:
        call()
    finally:
        sys.setprofile(None)
    files = {file.as_posix() for package in PACKAGES for file in (ROOT / package).rglob("*.py")}
    functions = [code for code in codes if code.co_flags & CO_OPTIMIZED]  # the body of a class is not one
    return {
        (str(Path(code.co_filename).relative_to(ROOT)), code.co_qualname)
        for code in functions
        if code.co_filename in files
    }


def _run(arguments: list[str]) -> None:
    for package in PACKAGES:
        for file in (ROOT / package).rglob("*.py"):
            if file.name != "driver.py":  # runs inside LinuxCNC
                import_module(".".join(file.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"))
    if arguments[0] == "python":
        import hexcite as hx

        case = hx.load_case("hexapod")
        places = _trace(lambda: hx.identify(hx.read(arguments[1], case), case))
    else:
        from hexcite.cli import app

        places = _trace(lambda: app(arguments, standalone_mode=False))
    print()
    print(json.dumps(sorted(places)))


if __name__ == "__main__":
    if len(sys.argv) > 1:
        _run(sys.argv[1:])
    else:
        from tests.bench.tables import print_table

        print_table("Files that a command runs through", COLUMNS, crossed(listed=True))
