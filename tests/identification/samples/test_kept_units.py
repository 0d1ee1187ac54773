"""Forces in another unit than the case keeps: the refusal names the kept unit, and its remedy reads the run."""

from pathlib import Path

import numpy as np
import pytest

from cases.base.errors import Code, IdentificationError, RecordingError
from cases.recording_format import RecordingFormat
from cases.schema import Case
from identification.finding import Finding
from identification.identify import identify
from identification.recording.recording import Recording, read
from identification.samples.sample_checks import scan
from tests.bench.reliability.recordings import simulated

NAMES = [f"F{k} [{{}}]" for k in range(1, 7)]


def _written(folder: Path, label: str, factor: float) -> Path:
    rows = simulated().rows.copy()
    rows[:, 7:13] *= factor
    forces = [name.format(label) if label else name.split()[0] for name in NAMES]
    head = ",".join(["t_s", *(f"l{k}_mm" for k in range(1, 7)), *forces, "trigger"])
    file = folder / "run.csv"
    np.savetxt(file, rows, delimiter=",", header=head, comments="", fmt="%.9g")
    return file


def _with(case: Case, label: str, unit: str) -> Case:
    columns = {f"f{k}_N": NAMES[k - 1].format(label) if label else f"F{k}" for k in range(1, 7)}
    form = {"columns": columns, "filter_cutoff_Hz": 40.0, "units": {"forces": unit}}
    return case.model_copy(update={"recording": RecordingFormat.model_validate(form)})


def _contradiction(recording: Recording) -> Finding:
    return next(f for f in recording.findings if "contradicted" in f.quantity)


@pytest.mark.parametrize("label", ["", "N"])
def test_a_kept_unit_that_no_sensor_reads_is_named_with_the_one_that_fits(
    label: str, hexapod_case: Case, tmp_path: Path
) -> None:
    file = _written(tmp_path, label, 1.0)
    case = _with(hexapod_case, label, "kN")
    with pytest.raises(RecordingError, match=r"recording\.units\.forces of the case says kN") as caught:
        scan(read([file], case), case)
    assert caught.value.code is Code.UNIT
    (remedy,) = caught.value.remedies
    ((place, unit, _),) = remedy.keys
    assert place == ("recording", "units", "forces")
    mended = _with(hexapod_case, label, unit)
    whole = scan(read([file], mended), mended).recording
    assert not whole.bad.any()
    assert np.allclose(whole.forces, simulated().rows[:, 7:13], rtol=1e-6, atol=1e-6)


def test_a_label_that_contradicts_the_case_is_a_remedy_where_forces_fit_it(hexapod_case: Case, tmp_path: Path) -> None:
    """Read as stated, the file's own unit is one key away; where it puts forces beyond the range, it is none."""
    case = _with(hexapod_case, "kN", "N")
    (remedy,) = _contradiction(read([_written(tmp_path, "kN", 1e-3)], case)).remedies
    ((place, unit, _),) = remedy.keys
    assert (place, unit) == (("recording", "units", "forces"), "kN")
    assert not _contradiction(read([_written(tmp_path, "kN", 1.0)], case)).remedies


def test_a_thousandth_of_the_mass_is_mended_by_the_kept_unit(hexapod_case: Case, tmp_path: Path) -> None:
    file, case = _written(tmp_path, "", 1e-3), _with(hexapod_case, "", "N")
    with pytest.raises(IdentificationError, match=r"forces seem to be in kN") as caught:
        identify(read([file], case), case)
    (remedy,) = caught.value.remedies
    ((_, unit, _),) = remedy.keys
    mended = _with(hexapod_case, "", unit)
    assert mended.nominal is not None
    assert identify(read([file], mended), mended).parameters["m"].value == pytest.approx(
        mended.nominal.mass_kg, rel=0.1
    )
