"""The exported HAL component in a running LinuxCNC: no force where nothing touches, where a force is added that one."""

import os
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from cases.base.units import DEG, MM
from cases.schema import load_case
from identification.model.model import identification_model
from identification.model.parameters import linear_parameters
from postprocessors.controllers.linuxcnc.isolation import preload_works
from postprocessors.controllers.linuxcnc.session import linuxcnc_missing
from postprocessors.export.code import half_window, linuxcnc_component
from tests.helpers import few
from tests.postprocessors.export.calibrations import calibration
from tests.postprocessors.export.compiled import SYSTEM_PATH, build_component
from tests.postprocessors.export.rig import run_rig

Array = NDArray[np.float64]
HERE = Path(__file__).parent
CASE = load_case("hexapod")
PUSH = np.array([30.0, -20.0, 50.0, 4.0, -3.0, 2.0])
LATE_AFTER_POSE = 4e-3  # the sensors, in cycles of 1 ms
LATE = 2e-3  # the same less the 2 cycles by which LinuxCNC's struts follow its pose
# Rapid moves, in which nothing but the machine's own limits bounds the acceleration. The push is on in the second half.
PROGRAM = """G17 G21 G40 G49 G54 G80 G90 G94 G64
G0 X120 Y-80 Z930 A8 B-6 C10
G0 X-150 Y100 Z880 A-10 B8 C-12
G0 X60 Y120 Z900 A5 B10 C0
M64 P1
G0 X-100 Y-120 Z940 A-8 B-9 C12
G0 X140 Y40 Z870 A10 B4 C-8
G0 X0 Y0 Z900 A0 B0 C0
M65 P1
G0 X60 Y0 Z900 A5 B0 C0
M2
"""


@pytest.fixture(scope="module")
def tools() -> None:
    no_compiler = "halcompile is missing; install the package linuxcnc-uspace-dev"
    missing = (no_compiler if shutil.which("halcompile", path=SYSTEM_PATH) is None else None) or linuxcnc_missing()
    if missing is None and not preload_works():
        missing = "components of a test's own cannot be loaded here: user namespaces are forbidden"
    if missing is not None:
        if os.environ.get("HEXCITE_REQUIRE_LINUXCNC") == "1":
            pytest.fail(f"HEXCITE_REQUIRE_LINUXCNC=1, but {missing}")
        pytest.skip(missing)


@pytest.fixture(scope="module")
def folder() -> Iterator[Path]:
    """A temporary folder that every user can enter, which pytest's own is not."""
    path = Path(tempfile.mkdtemp(prefix="test-component-", dir="/tmp"))
    path.chmod(0o755)
    yield path
    shutil.rmtree(path)


class Logged(NamedTuple):
    """What the rig logged, one row a cycle.

    Args:
        push: whether the force was added.
        valid: whether outputs were valid.
        wrench: of an instance that sees struts, shape (n, 6) [N, N m].
        found: x, y and a that it finds, shape (n, 3) [mm, degrees].
        commanded: the same as commanded.
        tared: wrench of an instance that sees the pose, and is tared while the force is added.
    """

    push: NDArray[np.bool_]
    valid: NDArray[np.bool_]
    wrench: Array
    found: Array
    commanded: Array
    tared: Array


def simulator(folder: Path, u: Array) -> Path:
    """The compiled sensors of a machine with parameters u."""

    def listed(values: Array) -> str:
        return ", ".join(repr(float(v)) for v in np.ravel(values))

    text = (HERE / "simforce.comp").read_text(encoding="ascii")
    head, code = text.split(";;\n")
    for word, values in (
        ("{ TRUTH }", u),
        ("{ JT }", np.linalg.inv(CASE.sensor_frame.structure)),
        ("{ PUSH }", PUSH),
    ):
        assert code.count(word) == 1
        code = code.replace(word, "{ " + listed(values) + " }")
    source = folder / "simforce.comp"
    source.write_text(f"{head};;\n{code}", encoding="ascii")
    return build_component(source)


@pytest.fixture(scope="module")
def logged(tools: None, folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Logged:
    assert CASE.simulation is not None
    u = linear_parameters(identification_model(CASE, 9), CASE.simulation.parameters)
    made = calibration(tmp_path_factory.mktemp("result"), "hexapod", 9, u, delay_s={"value": LATE, "std": 1e-5})
    source = folder / "hexapod_force.comp"
    source.write_text(linuxcnc_component(made, "hexapod_force"), encoding="ascii")
    modules = [build_component(source), simulator(folder, u)]
    hal = "loadrt simforce\nloadrt hexapod_force count=2\naddf simforce.0 servo-thread 3\n"
    hal += "addf hexapod-force.0 servo-thread 4\naddf hexapod-force.1 servo-thread 5\n"
    hal += "setp hexapod-force.1.from-pose 1\n"
    hal += f"setp hexapod-force.1.delay {LATE_AFTER_POSE!r}\n"
    hal += "net push motion.digital-out-01 => simforce.0.push hexapod-force.1.tare\n"
    for k in range(6):
        hal += f"net pose-{k} => simforce.0.pose-{k} hexapod-force.1.pose-{k}\n"
        hal += f"net strut-{k} => hexapod-force.0.strut-{k}\n"
        hal += f"net force-{k} simforce.0.force-{k} => hexapod-force.0.force-{k} hexapod-force.1.force-{k}\n"
    axes = ("fx", "fy", "fz", "mx", "my", "mz")
    pins = [("b", "@push"), ("b", "hexapod-force.0.valid")]
    pins += [("f", f"hexapod-force.0.{axis}") for axis in axes]
    pins += [("f", f"hexapod-force.0.platform-{k}") for k in (0, 1, 3)]
    pins += [("f", f"@pose-{k}") for k in (0, 1, 3)]
    pins += [("f", f"hexapod-force.1.{axis}") for axis in axes]  # a sampler has 20 pins
    session = folder / "session"
    session.mkdir()
    session.chmod(0o755)
    rows = run_rig(session, CASE, PROGRAM, hal, modules, pins)
    return Logged(rows[:, 0] != 0, rows[:, 1] != 0, rows[:, 2:8], rows[:, 8:11], rows[:, 11:14], rows[:, 14:])


def filtered_noise() -> Array:
    """Standard deviation of the wrench from 1 N of white noise on each sensor behind the window."""
    half = round(half_window(CASE) * 1e3)
    triangle = np.r_[1 : half + 1, half - 1 : 0 : -1] / half**2
    return np.asarray(np.linalg.norm(triangle) * np.linalg.norm(CASE.sensor_frame.structure, axis=1))


def settled(logged: Logged, push: bool) -> NDArray[np.bool_]:
    """Cycles whose whole window lies before, or after, any change of the push."""
    changes = np.flatnonzero(np.diff(logged.push.astype(int))) + 1
    near = np.zeros(len(logged.push), dtype=bool)
    for change in changes:
        near[change : change + 60] = True
    return logged.valid & (logged.push == push) & ~near


@pytest.mark.linuxcnc
def test_nothing_touches_and_the_component_reads_noise(logged: Logged) -> None:
    rows = settled(logged, push=False)
    assert rows.sum() > 500
    rms = np.sqrt(np.mean(logged.wrench[rows] ** 2, axis=0))
    assert np.all(rms < 1.3 * filtered_noise()), rms / filtered_noise()
    assert np.all(rms > 0.7 * filtered_noise())


@pytest.mark.linuxcnc
def test_a_force_that_is_added_is_read(logged: Logged) -> None:
    rows = settled(logged, push=True)
    assert rows.sum() > 500
    error = logged.wrench[rows] - PUSH
    assert np.all(np.sqrt(np.mean(error**2, axis=0)) < 1.3 * filtered_noise())
    np.testing.assert_allclose(logged.wrench[rows].mean(axis=0), PUSH, atol=0.15)


@pytest.mark.linuxcnc
def test_the_machine_really_moved_and_the_pose_is_its(logged: Logged) -> None:
    """The pose belongs to the struts a window ago: 2 cycles of LinuxCNC, 11 of the window, 2 of the sensors' delay."""
    assert np.ptp(logged.commanded, axis=0).min() > 15.0
    late = 2 + round(half_window(CASE) * 1e3) + round(LATE * 1e3)
    rows = np.flatnonzero(logged.valid)
    rows = rows[rows >= late]
    error = logged.found[rows] - logged.commanded[rows - late]
    assert np.abs(error * [MM, MM, DEG]).max() < 2e-4  # what the window does to a pose at 6 m/s^2
    assert logged.valid[60:].all()


@pytest.mark.linuxcnc
def test_a_second_instance_from_the_pose_is_tared_by_its_pin(logged: Logged) -> None:
    """Tared while a force acts, it takes that force for zero: without it, it reads about its opposite."""
    ends = np.flatnonzero(np.diff(logged.push.astype(int)) < 0)
    (end,) = ends
    before, after = settled(logged, push=False), settled(logged, push=False)
    before[end:], after[: end + 1] = False, False
    assert before.sum() > 300
    assert after.sum() > 50
    assert np.all(np.sqrt(np.mean(logged.tared[before] ** 2, axis=0)) < 1.3 * filtered_noise())
    # The window still held forces without push when the tare began, and with it when it ended: 2 % of the samples.
    np.testing.assert_allclose(logged.tared[after].mean(axis=0), -PUSH, rtol=0.04, atol=0.4)


@pytest.mark.usefixtures("tools")
@pytest.mark.parametrize(("name", "delay"), few(("ft_wrist", 0.0), ("hexapod", -0.0017)))
def test_components_of_other_sensors_and_delays_compile(name: str, delay: float, tmp_path: Path) -> None:
    made = calibration(tmp_path, name, 6, delay_s={"value": delay, "std": 1e-4})
    source = tmp_path / "some_force.comp"
    source.write_text(linuxcnc_component(made, "some_force"), encoding="ascii")
    assert build_component(source).exists()
