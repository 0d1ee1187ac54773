"""Models of chains take joints of any number: C, Structured Text and Python find the force that acts on the load.

The forces come from a machine written down in NumPy, whose motion is differentiated numerically.
"""

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from cases.schema import Case, load_case
from identification.model.model import full_model, identification_model
from identification.model.parameters import linear_parameters
from identification.results.result import Result
from postprocessors.export.code import python_module, structured_text
from tests.chains import chain_case
from tests.machines_in_numpy import ChainPlant
from tests.postprocessors.export.calibrations import write_result
from tests.postprocessors.export.compiled import OK, Chain, Compiled
from tests.postprocessors.export.plc import Plc

CASES = ["ur10_wrist without its last joint", "ur10_wrist", "ur10_wrist on a rail", "five_axis_table"]
ACTING = np.array([12.0, -7.0, 30.0, 0.4, -0.2, 0.1])
"""A force and a moment that act on the load from outside."""
AT = np.linspace(0.3, 2.1, 7)


def machine(name: str) -> Case:
    if name == "five_axis_table":
        return load_case(name)
    return chain_case({CASES[0]: 5, CASES[1]: 6, CASES[2]: 7}[name])


class Swing:
    """Joints that swing about home, each at its own pace."""

    def __init__(self, case: Case) -> None:
        assert case.chain is not None
        self.home = case.chain.home
        self.size = np.where([joint.turns for joint in case.chain.joints], 0.3, 0.05)
        self.pace = 2.0 + 0.7 * np.arange(len(self.home))

    def __call__(self, t: np.ndarray) -> np.ndarray:
        return np.asarray(self.home + self.size * np.sin(np.outer(t, self.pace)))

    def derivatives(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        phase = np.outer(t, self.pace)
        return self.size * self.pace * np.cos(phase), -self.size * self.pace**2 * np.sin(phase)


def calibrated(case: Case, folder: Path) -> Result:
    """The result whose parameters are those of the simulated machine."""
    number = full_model(case)
    truth = linear_parameters(identification_model(case, number), case.need_simulation("a test").parameters)
    return Result.load(write_result(folder, case, number, truth), case)


def sensed(case: Case, swing: Swing, t: np.ndarray) -> np.ndarray:
    """What the sensor reads while the load is pushed."""
    plant = ChainPlant.of(case.model_dump(mode="json", exclude_none=True))
    return plant.forces(plant.motion(swing, t), -ACTING)


def module_of(result: Result, folder: Path, name: str = "found") -> ModuleType:
    """The exported Python, imported."""
    file = folder / f"{name}.py"
    file.write_text(python_module(result, name), encoding="ascii")
    spec = importlib.util.spec_from_file_location(f"{folder.name}_{name}", file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look for it there
    spec.loader.exec_module(module)
    return module


@pytest.mark.first(1)
@pytest.mark.usefixtures("gcc")
@pytest.mark.parametrize("name", CASES)
def test_joints_of_any_number_give_what_acts_on_the_load(name: str, tmp_path: Path) -> None:
    case = machine(name)
    result, swing = calibrated(case, tmp_path), Swing(case)
    q, (rates, accelerations), forces = swing(AT), swing.derivatives(AT), sensed(case, swing, AT)
    compiled, model = Compiled(result, tmp_path), module_of(result, tmp_path).Model()
    plc = Plc().load(structured_text(result, "found"))
    block = plc.block("FB_Found")
    over = np.zeros(max(0, 6 - q.shape[1]))
    for k in range(len(AT)):
        by_c = compiled.wrench("from_joints", q[k], rates[k], accelerations[k], forces[k])
        np.testing.assert_allclose(by_c, ACTING, atol=2e-4)
        by_python = model.from_joints(q[k], rates[k], accelerations[k], forces[k])
        np.testing.assert_allclose(by_python, by_c, atol=1e-10)
        given = (np.r_[v, over].tolist() for v in (q[k], rates[k], accelerations[k]))
        inputs = dict(zip(("Position", "Velocity", "Acceleration"), given, strict=True))
        plc.cycle("FB_Found", block, **inputs, Forces=forces[k].tolist())
        np.testing.assert_allclose(block["wrench"].value, by_c, atol=1e-9)
        np.testing.assert_allclose(model.pose, np.array(compiled.model.pose), atol=1e-12)


@pytest.mark.usefixtures("gcc")
@pytest.mark.parametrize("name", [CASES[0], CASES[2]])
def test_the_signal_chain_takes_as_many_joints(name: str, tmp_path: Path) -> None:
    """Samples in, what acts on the load out: C and Python alike, for five joints and for seven."""
    case = machine(name)
    result, swing, step = calibrated(case, tmp_path), Swing(case), 0.001
    t = np.arange(0.3, 0.45, step)
    q, forces = swing(t), sensed(case, swing, t)
    width = max(6, q.shape[1])
    compiled, module = Compiled(result, tmp_path), module_of(result, tmp_path)
    chain, signals = Chain(compiled, step, 0.01, 0.0, width), module.Signals(step, 0.01, 0.0)
    found = 0
    for row, force in zip(q, forces, strict=True):
        status, sample = chain.push(np.r_[row, np.zeros(width - len(row))], force), signals.push(row, force)
        assert (status == OK) == (sample is not None)
        if sample is None:
            continue
        found += 1
        moved = [np.array(getattr(chain.sample, key))[: len(row)] for key in ("position", "velocity", "acceleration")]
        for ours, theirs in zip(sample, [*moved, np.array(chain.sample.force)], strict=True):
            np.testing.assert_allclose(ours, theirs, atol=1e-7)
        np.testing.assert_allclose(module.Model().from_joints(*sample), ACTING, atol=0.05)
    assert found > 100
