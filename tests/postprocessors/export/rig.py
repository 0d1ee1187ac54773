"""A LinuxCNC that loads realtime components from the test's own folder and logs the pins that a test names."""

import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from postprocessors.controllers.linuxcnc import configuration, session
from postprocessors.controllers.linuxcnc.isolation import run_session

Array = NDArray[np.float64]
HERE = Path(__file__).parent
SPEEDUP = 10.0


def run_rig(
    folder: Path, case: Case, program: str, hal: str, modules: list[Path], pins: list[tuple[str, str]]
) -> Array:
    """Runs a program.

    Args:
        folder: empty, and open to every user.
        case: gives the machine.
        program: LinuxCNC code without dwells.
        hal: further HAL commands. Strut k is the signal strut-k, coordinate k of the pose pose-k.
        modules: compiled realtime modules.
        pins: type (b, f, s) and name of what is logged each cycle.

    Returns:
        One row a cycle.
    """
    assert case.machine is not None
    configuration.write_configuration(folder, case, 1.0)
    kinds = "".join(kind for kind, _ in pins)
    layout = configuration.AxisLayout.of(case)
    usual = layout.sampler
    for name in (configuration.INI_FILE, configuration.HAL_FILE):
        text = (folder / name).read_text(encoding="ascii")
        assert usual in text
        lines = [line.replace(usual, kinds) for line in text.splitlines() if not line.startswith("net log-")]
        (folder / name).write_text("\n".join(lines) + "\n", encoding="ascii")
    with (folder / configuration.HAL_FILE).open("a", encoding="ascii") as file:
        for k, strut in enumerate(layout.joints):
            file.write(f"net strut-{k} {strut}.pos-cmd\n")
        for k, axis in enumerate(layout.axes.lower()):
            file.write(f"net pose-{k} axis.{axis}.pos-cmd\n")
        file.write("net trigger motion.digital-out-00\n" + hal)
        for k, (_, name) in enumerate(pins):
            source, _, signal = name.partition("@")  # pin, or @signal where the pin has one already
            file.write(f"net {signal or f'log-{k}'} {source} => sampler.0.pin.{k}\n".replace("  ", " "))
    for module in modules:
        shutil.copy(module, folder)
        (folder / module.name).chmod(0o755)
    (folder / session.PROGRAM_FILE).write_text(program, encoding="ascii")
    driver = folder / configuration.DISPLAY_FILE
    driver.write_bytes((Path(session.__file__).parent / "driver.py").read_bytes())
    driver.chmod(0o755)
    warp = Path(session.__file__).parent / "warp.c"
    for library, c_file, more in (
        (session.CLOCK_FILE, warp, ["-pthread"]),
        ("modules.so", HERE / "modules.c", []),
    ):
        subprocess.run(["gcc", "-O2", "-shared", "-fPIC", *more, "-o", library, c_file, "-ldl"], cwd=folder, check=True)
    environment = {
        "HEXCITE_SPEEDUP": repr(SPEEDUP),
        "HEXCITE_MODULES": "{folder}",
        "LD_PRELOAD": f"{{folder}}/{session.CLOCK_FILE}:{{folder}}/modules.so",
    }
    code = run_session(folder, ["-r", configuration.INI_FILE, session.PROGRAM_FILE, "60", "1.0"], environment, 100.0)
    output = (folder / "linuxcnc.out").read_text(errors="replace")
    assert (folder / "status.json").exists(), output
    status = json.loads((folder / "status.json").read_text())
    assert status["outcome"] == "done", (code, status, output)
    assert status["lost"] == 0
    return np.fromfile(folder / "samples.f64").reshape(status["samples"], 1 + len(pins))[:, 1:]
