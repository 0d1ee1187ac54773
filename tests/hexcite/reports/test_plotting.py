"""`plot`: each value's figure shows the value's own numbers, in the units of its axes."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import hexcite as hx
from cases.base.errors import HexciteError
from identification.machines.hexapod import Hexapod
from identification.simulate import simulate_recording
from planner.bounds.bound import Bound
from tests.bench.table_3 import standing_run
from tests.helpers import SHORT_MOVES, Harmonic
from tests.simulated_machine import PoseExecution


@pytest.fixture(scope="module")
def run() -> hx.Recording:
    case = hx.load_case("hexapod")
    execution = PoseExecution(Hexapod.of(case), Harmonic(seed=3, duration=4.0))
    return replace(simulate_recording(case, execution, np.array([[0.3, 3.7]]), 1), case=case)


@pytest.fixture(scope="module")
def result(run: hx.Recording) -> hx.Result:
    return hx.identify(run, hx.load_case("hexapod"))


def test_a_run_is_drawn_with_what_moved_and_what_was_measured(run: hx.Recording):
    drives, forces = hx.plot(run).axes
    assert "[mm]" in drives.get_ylabel()
    assert forces.get_ylabel() == "force [N]"
    measured = forces.get_lines()[2].get_ydata()
    assert measured.max() == pytest.approx(run.forces[:, 2].max())
    assert measured.min() == pytest.approx(run.forces[:, 2].min())
    assert drives.get_lines()[5].get_ydata().max() == pytest.approx(1e3 * run.drives[:, 5].max())
    assert forces.get_lines()[0].get_xdata()[-1] == pytest.approx(run.t[-1], abs=0.05)  # type: ignore[index]


def test_a_result_is_drawn_with_its_residuals_and_a_loaded_one_with_correlations(result: hx.Result, tmp_path: Path):
    assert [axes.get_ylabel() for axes in hx.plot(result).axes][:2] == ["force [N]", "recorded - model [N]"]
    result.save(tmp_path / "result")
    heat, _ = hx.plot(hx.Result.load(tmp_path / "result")).axes
    assert [label.get_text() for label in heat.get_xticklabels()] == list(result.model.names)
    np.testing.assert_allclose(np.diag(heat.images[0].get_array()), 1.0)


def test_plans_cases_and_forces_are_drawn(run: hx.Recording, result: hx.Result, tmp_path: Path):
    case = hx.load_case("hexapod")
    plan = hx.plan(case, hx.Manual(SHORT_MOVES))
    axes = hx.plot(plan).axes
    assert [each.get_ylabel() for each in axes[:2]] == ["position from home [mm]", "position from home [deg]"]
    hx.plot(plan).savefig(tmp_path / "plan.pdf")
    assert (tmp_path / "plan.pdf").read_bytes().startswith(b"%PDF")
    assert len(hx.plot(case).axes) == 3
    found = hx.force(run, result)
    force, moment = hx.plot(found).axes
    assert (force.get_ylabel(), moment.get_ylabel()) == ("force [N]", "moment [N m]")
    assert force.get_lines()[0].get_ydata().max() == pytest.approx(found.wrench[:, 0].max())


def test_a_notebook_shows_what_plot_returns():
    """Also one in which nothing has set matplotlib up."""
    assert hx.plot(hx.load_case("hexapod"))._repr_png_().startswith(b"\x89PNG")  # type: ignore[attr-defined]


def test_models_identifiability_and_a_bound_are_drawn():
    case = hx.load_case("hexapod")
    run = standing_run(case, 1.0, 0)
    choice = hx.identify_models(run, case)
    predicted = {row.model: row.predicted for row in choice.rows if row.reason is None}
    (axes,) = hx.plot(choice).axes
    assert [label.get_text() for label in axes.get_xticklabels()][4] == "model 5 (preferred)"
    np.testing.assert_allclose(axes.get_lines()[0].get_ydata(), list(predicted.values()))
    found = hx.identifiability(run, 5, case)
    columns, qr = (axes for axes in hx.plot(found).axes if axes.images)
    np.testing.assert_allclose(columns.images[0].get_array(), np.abs(found.correlation))
    np.testing.assert_allclose(qr.images[0].get_array(), np.abs(found.r), atol=1e-12)
    bound = Bound(10.0, 20.0, 20, "by hand", True, 8.0)
    (axes,) = hx.plot(bound).axes
    line = axes.get_lines()[0]
    assert line.get_ydata()[-1] == pytest.approx(1.0)  # type: ignore[index]
    assert np.interp(8.0, line.get_xdata(), line.get_ydata()) == pytest.approx(np.exp(-0.1), rel=1e-4)


def test_a_result_is_drawn_with_its_accelerations(result: hx.Result):
    titles = [axes.get_ylabel() for axes in hx.plot(result).axes]
    assert [t for t in titles if t.startswith("acceleration")] == ["acceleration [m/s²]", "acceleration [rad/s²]"]


def test_what_has_no_figure_says_what_has():
    with pytest.raises(HexciteError, match=r"plot.*3.*Recording"):
        hx.plot(3)
