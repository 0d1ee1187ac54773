"""`hexcite identify` with everything that can be asked of it: several files, known values, priors, weights."""

import json
from pathlib import Path

import numpy as np
import pytest

from cases.schema import load_case
from cases.tables import built_in_cases
from identification.identify import identify
from identification.machines.hexapod import Hexapod
from identification.recording.recording import Recording, write_recording
from identification.results.pooling import pool
from identification.results.result import Result
from identification.simulate import simulate_recording
from tests.helpers import Harmonic, tells
from tests.hexcite.command_line import call, refused
from tests.simulated_machine import PoseExecution

CASE = load_case("hexapod")


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with one run: as CSV, as Parquet, and as two CSV files of struts and forces."""
    folder = tmp_path_factory.mktemp("run")
    execution = PoseExecution(Hexapod.of(CASE), Harmonic(seed=1, duration=2.0))
    recording = simulate_recording(CASE, execution, np.array([[0.2, 1.8]]), 0)
    for name in ("run.csv", "run.parquet"):
        write_recording(folder / name, recording, CASE)
    rows = [line.split(",") for line in (folder / "run.csv").read_text().splitlines()]
    (folder / "struts.csv").write_text("".join(",".join([*r[:7], r[13]]) + "\n" for r in rows))
    (folder / "forces.csv").write_text("".join(",".join([r[0], *r[7:13]]) + "\n" for r in rows))
    return folder


def answer_of(run: Path, tmp_path: Path, *words: object, files: tuple[str, ...] = ("run.csv",)) -> dict:
    names = [run / f for f in files]
    return call(
        "identify", *names, "--case", "hexapod", "-o", tmp_path / "result", "--overwrite", "--json", *words
    ).json()


@pytest.fixture(scope="module")
def alone(run: Path, tmp_path_factory: pytest.TempPathFactory) -> dict:
    """The answer about the run as one file, with nothing else asked for."""
    return answer_of(run, tmp_path_factory.mktemp("alone"))


@pytest.mark.first(1)
@pytest.mark.parametrize(
    "files",
    [
        ("run.parquet",),
        ("forces.csv", "struts.csv"),
        pytest.param(("struts.csv", "forces.csv"), marks=pytest.mark.slow),
    ],
)
def test_the_same_run_in_other_files_gives_the_same_result(
    files: tuple[str, ...], alone: dict, run: Path, tmp_path: Path
) -> None:
    other = answer_of(run, tmp_path, files=files)
    assert other["linear"]["values"] == pytest.approx(alone["linear"]["values"], rel=1e-9)
    assert [Path(i["file"]).name for i in other["inputs"]] == list(files)
    assert all(len(i["sha256"]) == 64 for i in other["inputs"])
    assert other["versions"]["numpy"] == np.__version__


def test_known_values_are_kept_and_left_out_ones_are_zero(run: Path, tmp_path: Path) -> None:
    answer = answer_of(run, tmp_path, "--fix", "m=31.83kg", "--fix", "xC=0.01mm", "--drop", "I12")
    assert answer["known"] == pytest.approx({"m": 31.83, "xC": 1e-5})
    assert answer["dropped"] == ["I12"]
    assert answer["rank"] == 17
    p = answer["parameters"]
    assert (p["m"]["value"], p["m"]["std"]) == (pytest.approx(31.83), 0.0)
    assert p["xC"]["value"] == pytest.approx(1e-5)
    assert p["k3"]["std"] > 0.0


@pytest.mark.usefixtures("causes_aside")
def test_priors_stand_in_the_result_and_a_wrong_one_is_warned_of(run: Path, tmp_path: Path) -> None:
    answer = answer_of(run, tmp_path, "--prior", "m=33+-0.5kg", "--prior", "zC=0.105+-0.001m")
    assert answer["priors"]["m"] == {"value": 33.0, "std": 0.5}
    assert sum("disagrees with the data" in warning for warning in answer["warnings"]) == 0
    wrong = answer_of(run, tmp_path, "--prior", "m=40+-0.5kg")
    assert any("prior m disagrees with the data" in warning for warning in wrong["warnings"])


@pytest.mark.repeats
def test_people_are_told_which_deviation_to_trust(run: Path, tmp_path: Path) -> None:
    shown = call("identify", run / "run.csv", "--case", "hexapod", "-o", tmp_path / "result", "--fix", "m=31.83kg").out
    assert "larger of std (28)" in shown
    assert next(line for line in shown.splitlines() if "(m)" in line).split()[3] == "given"


WRONG = {
    "no unit": (("--fix", "m=3"), "--fix m=3: has no unit; give kg"),
    "a unit of something else": (("--fix", "m=3mm"), "unit mm does not fit m; give kg"),
    "no number": (("--fix", "m=heavy"), "is not understood; write --fix m=93.1kg"),
    "an unknown name": (("--fix", "mass=3kg"), "mass is not a parameter of model 9; choose from m, mxC"),
    "twice": (("--fix", "m=3kg", "--fix", "m=4kg"), "given twice"),
    "uncertain but exact": (("--fix", "m=3+-1kg"), "write an uncertain value as --prior m=3+-1kg"),
    "a prior without deviation": (("--prior", "m=3kg"), "write it as --prior m=33+-0.5kg"),
    "a prior that is certain": (("--prior", "m=3+-0kg"), "deviation above 0"),
    "a dropped name": (("--drop", "k7"), "'k7' is not a parameter"),
    "a central inertia alone": (("--fix", "IC11=1kgm2"), "cannot be fixed"),
}


@pytest.mark.parametrize("what", WRONG)
def test_what_cannot_be_asked_is_refused(what: str, run: Path, tmp_path: Path) -> None:
    words, says = WRONG[what]
    assert says in refused("identify", run / "run.csv", "--case", "hexapod", "-o", tmp_path / "r", *words)
    assert not (tmp_path / "r").exists()


@pytest.mark.parametrize("option", ["--biases=result", "--terms=K1", "--flexible"])
def test_options_of_earlier_versions_are_refused(option: str, run: Path) -> None:
    answer = call("identify", run / "run.csv", "--case", "hexapod", option)
    assert answer.code == 2
    assert option.split("=")[0] in answer.err


def test_a_run_to_verify_on_that_is_not_there_is_told_before_a_result_is_written(run: Path, tmp_path: Path) -> None:
    words = ("--case", "hexapod", "--verify", tmp_path / "none.csv", "-o", tmp_path / "result")
    line = refused("identify", run / "run.csv", *words)
    assert "none.csv: cannot be read" in line
    assert not (tmp_path / "result").exists()


def test_two_files_of_one_kind_are_refused(run: Path, tmp_path: Path) -> None:
    line = refused("identify", run / "run.csv", run / "forces.csv", "--case", "hexapod", "-o", tmp_path / "r")
    assert "files of one run" in line


@pytest.mark.repeats
def test_weights_are_chosen_by_name_and_follow_from_the_noise_that_the_case_states(run: Path, tmp_path: Path) -> None:
    noise = "[sensors]\nforce_noise_N = 1.0\nangular_acceleration_noise_rad_s2 = 0.2"
    text = built_in_cases()["hexapod"].read_text(encoding="utf-8").replace("[sensors]", noise)
    (tmp_path / "case.toml").write_text(text, encoding="utf-8")
    words = ("identify", run / "run.csv", "--case", tmp_path / "case.toml", "--weights", "stated")
    assert "weights stated" in " ".join(call(*words, "-o", tmp_path / "result").out.split())
    saved = json.loads((tmp_path / "result" / "result.json").read_text())
    assert saved["weights"] == "stated"
    plain = ("identify", run / "run.csv", "--case", "hexapod", "-o", tmp_path / "r", "--weights")
    assert "give sensors.force_noise_N and acceleration_noise_m_s2" in refused(*plain, "stated")
    assert tells(refused(*plain, "mine"), "weights 'mine'", "choose equal, per_channel, per_unit, stated")


@pytest.mark.repeats
def test_all_models_are_compared_and_the_best_is_kept(run: Path, tmp_path: Path) -> None:
    answer = answer_of(run, tmp_path, "--model", "all")
    assert answer["model"] == answer["models"]["best"] == 9
    assert len(answer["models"]["models"]) == 11
    saved = json.loads((tmp_path / "result" / "result.json").read_text(encoding="utf-8"))
    assert saved["models"] == answer["models"]
    assert "Table 3" in (tmp_path / "result" / "report.html").read_text(encoding="utf-8")
    line = refused("identify", run / "run.csv", "--case", "hexapod", "--model", "most", "-o", tmp_path / "no")
    assert tells(line, "--model most", "all")


@pytest.fixture(scope="module")
def again(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same thing once more, in another motion and with other noise, in a file of the same name."""
    folder = tmp_path_factory.mktemp("again")
    execution = PoseExecution(Hexapod.of(CASE), Harmonic(seed=2, duration=2.0))
    write_recording(folder / "run.csv", simulate_recording(CASE, execution, np.array([[0.2, 1.8]]), 1), CASE)
    return folder


@pytest.mark.repeats
def test_runs_are_identified_each_and_pooled_as_single_results_are(run: Path, again: Path, tmp_path: Path) -> None:
    files = [run / "run.csv", again / "run.csv"]
    folder = tmp_path / "together"
    words = ("--case", "hexapod", "-o", folder)
    shown = call("identify", *files, "--runs", *words)
    assert shown.code == 0, shown.err
    assert sum("= " in line and str(folder / "runs") in line for line in shown.out.splitlines()) == 2
    assert tells(shown.out, "share of chi-square")
    together = Result.load(folder)
    alone = [identify(Recording.load(file, CASE)) for file in files]
    np.testing.assert_allclose(together.values, pool(alone).values, rtol=1e-12)
    np.testing.assert_allclose(together.covariance_robust, pool(alone).covariance_robust, rtol=1e-12)
    for name, of in zip(("run", "run-2"), alone, strict=True):
        assert Result.load(folder / "runs" / name).values == pytest.approx(of.values, rel=1e-12)
        assert (folder / "runs" / name / "report.html").exists()
    later = call("identify", *reversed(files), "--runs", *words, "--overwrite", "--json").json()
    assert later["parameters"]["m"]["value"] == pytest.approx(together["m"].value, rel=1e-9)
    assert [Path(each["result"]).name for each in later["runs"]] == ["run", "run-2"]


def test_a_run_that_is_refused_is_named_and_nothing_is_written(run: Path, tmp_path: Path) -> None:
    short = tmp_path / "short.csv"
    short.write_text("".join((run / "run.csv").read_text().splitlines(keepends=True)[:120]))
    folder = tmp_path / "together"
    words = ("--runs", "--case", "hexapod", "-o", folder)
    for other in (short, run / "forces.csv", tmp_path / "absent.csv"):
        assert str(other) in refused("identify", run / "run.csv", other, *words)
    assert "same recording" in refused("identify", run / "run.csv", run / "run.csv", *words)
    assert "two runs" in refused("identify", run / "run.csv", *words)
    assert "--model all" in refused("identify", run / "run.csv", short, *words, "--model", "all")
    assert "--prior m=" in refused("identify", run / "run.csv", short, *words, "--prior", "m=33+-0.5kg")
    assert [path.name for path in tmp_path.iterdir()] == ["short.csv"]
