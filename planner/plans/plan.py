"""A plan: the chosen motion or set of poses, its predicted figures, and the proof of its limits."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import TypeAdapter

from cases.base.atomic import atomic_folder
from cases.base.doors import checks
from cases.base.errors import Code, FileProblem, HexciteError
from cases.base.file_reading import read_json
from cases.base.folder_kinds import PLAN
from cases.base.output_places import check_folder
from cases.base.phrases import Phrase, enumerated, phrase, said
from cases.base.text_formats import json_text
from cases.base.units import DEG, MM, as_html
from cases.basis import COMPUTED_FROM, CONTENT, case_of, content_of, plan_basis, require_unchanged
from cases.schema import Case
from identification.limits.limit import LimitKind, LimitReport, Status
from identification.model.model import identification_model
from identification.model.parameters import physical_form
from identification.motion.motion import Array, Joined, Motion, Standstill, Trajectory, sample
from identification.texts import (
    CAUSE,
    aligned,
    budget_cells,
    carries_rods,
    legible,
    limit_lines,
    parameter_words,
    std_text,
    use_text,
)
from planner.families.plan_settings import PlanSettings
from planner.options import family_phrase
from planner.plans.figures import PoseWorth, Worth, bound_by
from planner.plans.folder import (
    LONGEST_OF_POSES,
    SCHEMA_VERSION,
    Entries,
    fingerprint_of,
    motion_entries,
    motion_of_entries,
    refusing,
)
from planner.plans.prediction import Gain, Promise
from planner.request import LONGEST, PoseRequest, Request

SAMPLE_RATE = 1000.0  # [1/s] of motion.csv
MOST_USED = 0.9  # share of a limit from which it is shown


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """A planned excitation: a motion from rest to rest, or poses to stand at.

    >>> plan = hx.Plan.load("plan")
    >>> plan
    Plan for hexapod: manual motion, 4.35 s, criterion D, model 9
    limits most used: ...
    D-efficiency 0.188 against the box bound (certified)
    >>> f"{plan.predicted_std['m']:.4f} kg"
    '0.0066 kg'

    Args:
        case: case that it was planned for.
        request: request that it answers.
        motion: the excitation; of poses from home through all of them and back home.
        limits: proof of its limits.
        promise: predicted standard deviation of each physical parameter for one run, with its parts.
        assumed_noise: assumed noise of a force sample behind it, of poses of an averaged force [N].
        assumed_rate: samples of a recording a second behind it [1/s].
        worth: figures of the motion or of the poses, and the record of their search.
        settings: settings of the family after the search; of poses origin of the candidates, and measuring time.
        solve_s: computing time [s].
        interrupted: whether Ctrl-C ended the search early.
        folder: folder from which it was loaded; None for a new plan.
        digest: fingerprint of the plan.json there.
        stale: changes of the case since then, where the user went on; written into what is made of the plan.
        gain: what its run adds to what earlier results say, where it was planned with some.
    """

    case: Case
    request: Request | PoseRequest
    motion: Trajectory
    limits: LimitReport
    promise: Promise
    assumed_noise: float
    assumed_rate: float
    worth: Worth | PoseWorth
    settings: PlanSettings
    solve_s: float
    interrupted: bool = False
    folder: Path | None = None
    digest: str = ""
    stale: tuple[str, ...] = ()
    gain: Gain | None = None

    @property
    def family(self) -> str:
        """Name of the family of motions, or `poses`."""
        return self.request.name

    @property
    def model(self) -> int:
        """Number in Table 2."""
        return self.request.model

    @property
    def duration(self) -> float:
        """Duration of the motion [s]."""
        return self.motion.duration

    @property
    def predicted_std(self) -> dict[str, float]:
        """Standard deviation of each physical parameter for one run [SI]."""
        return self.promise.std

    @property
    def std_after(self) -> dict[str, float]:
        """The same with what earlier results say, where it was planned with some: what targets are compared with."""
        return self.promise.std if self.gain is None else self.gain.after.std

    @property
    def poses(self) -> Array:
        """Poses at which it measures standing still, in order of visit, shape (n, k) [m or rad]; empty for motions."""
        parts = self.motion.parts if isinstance(self.motion, Joined) else ()
        poses = [part.coordinates for part in parts if isinstance(part, Standstill) and part.average]
        return np.array(poses) if poses else np.zeros((0, 6))

    @property
    def name(self) -> str:
        """Name of its folder, or of case and family."""
        return f"{self.case.name}-{self.family}" if self.folder is None else self.folder.resolve().name

    @property
    def without(self) -> tuple[LimitKind, ...]:
        """Families of limits of the case that it leaves out, as was asked for."""
        return () if self.settings.without is None else (self.settings.without,)

    @property
    def fingerprint(self) -> str:
        """Fingerprint of its plan.json, wherever the folder is, by which programs and recordings name it."""
        return self.digest or fingerprint_of(json_text(self.to_json()).encode())

    @property
    def of_motion(self) -> tuple[Request, Worth]:
        """Request and figures of a plan of a motion.

        Raises:
            HexciteError: it is a plan of poses.
        """
        if isinstance(self.request, Request) and isinstance(self.worth, Worth):
            return self.request, self.worth
        raise HexciteError(
            place=self.name,
            problem="is a plan of poses",
            remedy="here a plan of a motion is wanted",
            code=Code.WRONG_KIND,
        )

    @property
    def payloads(self) -> range:
        """Numbers of payloads that may be mounted."""
        return self.request.payloads if isinstance(self.request, Request) else range(1)

    def save(self, folder: Path | str, overwrite: bool = False) -> None:
        """Writes plan.json, and motion.csv or poses.csv, into a new folder.

        Raises:
            FileProblem: the folder is somebody's, or cannot be written.
        """
        check_folder(Path(folder), PLAN, overwrite=overwrite)
        with atomic_folder(Path(folder), PLAN, overwrite) as part:
            self.write(part)

    def write(self, folder: Path) -> None:
        """Writes the same files into an existing folder."""
        (folder / "plan.json").write_text(json_text(self.to_json()), encoding="utf-8")
        if isinstance(self.request, PoseRequest):
            poses = poses_in_units(self.poses, self.case)
            columns = "pose", *self.case.need_motion("a plan")[1].columns
            name, text = "poses.csv", _csv(columns, np.column_stack([np.arange(1, len(poses) + 1), poses]))
        else:
            name, text = "motion.csv", motion_csv(sample(self.motion, SAMPLE_RATE), self.case)
        (folder / name).write_text(text, encoding="utf-8")

    @classmethod
    @checks
    def load(cls, folder: Path | str, case: Case | None = None, stale: bool = False) -> "Plan":
        """The plan of a folder.

        Args:
            case: replaces the case that the plan names, which may have been moved.
            stale: whether to read it although its case has changed.

        Raises:
            FileProblem: the folder has no plan, it is damaged or changed by hand, or its case has changed since.
            CaseError: its case does not exist any more or is not valid.
        """
        file = Path(folder) / "plan.json"
        data = read_json(file, "hexcite plan")
        if data.get("schema_version") != SCHEMA_VERSION:
            raise FileProblem(
                place=file,
                problem=f"schema_version is {data.get('schema_version')!r}, not {SCHEMA_VERSION}",
                remedy="plan again",
                code=Code.VERSION,
            )
        with refusing(file):
            entries = Entries.model_validate(data)
            motion = motion_of_entries(data)
        of_poses = entries.family == PoseRequest.name
        if not 0.0 < motion.duration <= (LONGEST_OF_POSES if of_poses else LONGEST):
            raise FileProblem(
                place=file,
                problem=f"a motion of {motion.duration:g} s is not an excitation",
                remedy="plan again",
                code=Code.OUT_OF_RANGE,
            )
        case_of_plan = case_of(file, data, "plan again") if case is None else case
        count = len(case_of_plan.need_motion("a plan")[0])
        with refusing(file):
            if motion.at([0.0]).coordinates.shape[1] != count:
                raise HexciteError(
                    problem=f"its motion does not have the {count} coordinates of case {case_of_plan.name}",
                    code=Code.OTHER_SOURCE,
                )
        now = plan_basis(case_of_plan, entries.payload, of_poses)
        remarks = require_unchanged(file, data, now, case_of_plan, stale, phrase("plan_again", "plan again"))
        with refusing(file):
            request = PoseRequest.of_json(data) if of_poses else Request.of_json(data)
            worth = TypeAdapter(PoseWorth).validate_python(data) if of_poses else Worth.of_json(data)
            limits = LimitReport.of_json(data["limits"])
            names = [p.name for p in physical_form(identification_model(case_of_plan, request.model)).parameters]
            if list(entries.predicted_std) != names or not limits.checks:
                raise KeyError("predicted_std" if limits.checks else "limits")
            plan = cls(
                case_of_plan, request, motion, limits, entries.promise, entries.assumed_noise_N,
                entries.assumed_rate_Hz, worth, entries.settings, entries.solve_s, entries.interrupted,
                Path(folder), fingerprint_of(file.read_bytes()), remarks, entries.gain,
            )  # fmt: skip
        if entries.content != content_of(data):
            raise FileProblem(
                place=file,
                problem=phrase("plan_changed", "was changed by hand"),
                remedy=phrase("plan_again", "plan again"),
                code=Code.CHANGED,
            )
        return plan

    def to_json(self) -> dict[str, Any]:
        """What `plan.json` holds."""
        request = self.request
        if isinstance(request, Request):
            first, last = self.motion.at([0.0, self.duration]).coordinates
            plan_entries = {
                "first_pose_m_rad": first.tolist(),
                "last_pose_m_rad": last.tolist(),
                "payload": self.payloads[-1],
                "payload_from": self.payloads[0],
                "bound_by": bound_by(self.limits),
                "interrupted": self.interrupted,
            }
        else:
            columns = self.case.need_motion("a plan")[1].columns
            rows = poses_in_units(self.poses, self.case).tolist()
            plan_entries = {"count": len(rows), "poses": [dict(zip(columns, row, strict=True)) for row in rows]}
        entries = {
            "schema_version": SCHEMA_VERSION,
            "case": self.case.name,
            "case_file": self.case.origin,
            "case_hash": self.case.hash,
            COMPUTED_FROM: plan_basis(self.case, self.payloads[-1], isinstance(request, PoseRequest)),
            "family": self.family,
            "criterion": request.criterion,
            "model": request.model,
            "status": "proven",
            "duration_s": self.duration,
            "solve_s": self.solve_s,
            "settings": self.settings.to_json(),
            **request.to_json(),
            **self.worth.to_json(),
            **plan_entries,
            **self.promise.to_json(),
            "not_counted": self._not_counted,
            "assumed_noise_N": self.assumed_noise,
            "assumed_rate_Hz": self.assumed_rate,
            "pose_errors": None if (field := self.case.sensors.pose_field) is None else field.keys,
            "limits": self.limits.to_json(),
            **motion_entries(self.motion),
        }
        if self.gain is not None:
            entries["known"] = self.gain.to_json()
        if self.stale:
            entries["stale"] = list(self.stale)
        return entries | {CONTENT: content_of(entries)}

    @property
    def rating(self) -> tuple[float, Phrase]:
        """Its D-efficiency, and against what."""
        if isinstance(self.worth, PoseWorth):
            of_design = "of the best design over {count} candidates (lower bound)"
            return self.worth.efficiency, phrase("of_design", of_design, count=self.worth.candidates)
        label = said(self.worth.bound.label)
        return self.worth.d_efficiency, phrase("of_box_bound", "against the box bound ({label})", label=label)

    @property
    def doubts(self) -> tuple[str, ...]:
        """Why another plan would carry more information."""
        best = "stopped by Ctrl-C: this is the best of what was found until then"
        stopped = (phrase("stopped_early", best),) if self.interrupted else ()
        return stopped if isinstance(self.worth, PoseWorth) else (*stopped, *self.worth.weaknesses)

    @property
    def remarks(self) -> tuple[str, ...]:
        """What predicted standard deviations assume, and notes for the user before running it."""
        gained, noise = () if self.gain is None else self.gain.words, f"{self.assumed_noise:.3g}"
        if isinstance(self.worth, PoseWorth):
            standing = "predicted for {noise} N white noise of an averaged force"
            assumed = phrase("assumed_standing", standing, noise=noise)
            return self._counted(assumed), *gained, self.worth.remark, *self._lasting()
        assumed = phrase(
            "assumed_moving",
            "predicted for {noise} N white noise of a force, {rate} Hz, {mounted}, weights {weights}",
            noise=noise,
            rate=f"{self.assumed_rate:g}",
            mounted=self.of_motion[0].mounted,
            weights=said(self.worth.weights),
        )
        return self._counted(assumed), *gained, *self._lasting(), *self.worth.notes

    def _counted(self, assumed: Phrase) -> Phrase:
        """What predictions assume, and which tolerances they do not count."""
        if not self._not_counted:
            return assumed
        kinds = enumerated("comma", [phrase(CAUSE, kind, name=kind) for kind in self._not_counted])
        whole = "{assumed}; no tolerances of {kinds} are counted: see [tolerances]"
        return phrase("tolerances_missing", whole, assumed=assumed, kinds=kinds)

    @property
    def _not_counted(self) -> list[str]:
        """Kinds of tolerances that no predicted deviation counts."""
        return self.promise.not_counted(self.case, isinstance(self.request, PoseRequest))

    def _lasting(self) -> tuple[str, ...]:
        """Whether a longer run of its kind would gain little."""
        model = identification_model(self.case, self.model)
        targets = self.request.target if isinstance(self.request, Request) else {}
        longer = phrase("more_seconds", "more seconds lower")
        if not isinstance(self.request, Request):
            longer = phrase("longer_averages", "longer averages lower")
        promise = self.promise if self.gain is None else self.gain.after
        words = promise.lasting_words(physical_form(model).parameters, targets, longer)
        return (words,) if words else ()

    @property
    def headline(self) -> Phrase:
        """What it is, in a line."""
        subject = family_phrase(self.family)
        if isinstance(self.worth, PoseWorth):
            subject = phrase("so_many_poses", "{count} poses", count=len(self.poses))
        line = phrase(
            "headline",
            "Plan for {machine}: {subject}, {seconds} s, criterion {criterion}, model {model}",
            machine=self.case.name,
            subject=subject,
            seconds=f"{self.duration:.2f}",
            criterion=self.request.criterion,
            model=self.model,
        )
        left_out = ", ".join(self.without)
        return (
            phrase("headline_without", "{line}, without {left_out}", line=line, left_out=left_out) if left_out else line
        )

    def _verdict(self) -> list[str]:
        efficiency, measure = self.rating
        return [*(f"weak: {doubt}" for doubt in self.doubts), f"D-efficiency {efficiency:.3f} {measure}"]

    def __repr__(self) -> str:
        """A few lines: the excitation, the limits that it uses most, and its rating."""
        counted = (c for c in self.limits.checks if c.binding)
        most = sorted(counted, key=lambda c: (c.room is not None, -c.ratio))[:3]
        limits = ", ".join(f"{c.name} {use_text(c, unit=c.unit)}" for c in most)
        return "\n".join([self.headline, f"limits most used: {limits}", *self._verdict()])

    def __str__(self) -> str:
        """The same with predicted standard deviations, and a table of the limits that matter."""
        checks = [c for c in self.limits.checks if c.ratio >= MOST_USED or c.status is not Status.PROVEN]
        limits = [*limit_lines(checks), f"{len(self.limits.checks) - len(checks)} other limits are proven too"]
        deviations = aligned(*self.deviation_rows())
        deviations += aligned(*self.budget_rows())
        remarks = (f"note: {remark}" for remark in self.remarks)
        return "\n".join([self.headline, "", *limits, "", *deviations, "", *remarks, *self._verdict()])

    _repr_html_ = as_html

    def deviation_rows(self) -> list[tuple[str, ...]]:
        """Rows of a table, its head first: parameters in words, their predicted deviations, units.

        Where something is known: also the deviations by that alone, and with the run.
        """
        columns, rods = {"predicted std": self.predicted_std}, carries_rods(self.predicted_std)
        if self.gain is not None:
            columns |= {"known": self.gain.before, "with this run": self.gain.after.std}
        rows: list[tuple[str, ...]] = [("parameter", *columns, "unit")]
        for p in physical_form(identification_model(self.case, self.model)).parameters:
            scale, unit = legible(p.unit)
            deviations = (std_text(of[p.name] * scale) for of in columns.values())
            rows.append((parameter_words(p.name, rods), *deviations, unit))
        return rows

    def budget_rows(self) -> list[tuple[str, ...]]:
        """Rows of a table, its head first: parts of the predicted deviations; none where no tolerance is stated."""
        units = {p.name: p.unit for p in physical_form(identification_model(self.case, self.model)).parameters}
        return budget_cells(units, (self.promise if self.gain is None else self.gain.after).budget)


def poses_in_units(poses: Array, case: Case) -> Array:
    """Coordinates of a case's machine in mm and degrees, shape (n, k), without the noise of the conversion."""
    return np.asarray(np.round(poses / np.where(case.need_motion("a plan")[1].turns, DEG, MM), 9))


def motion_csv(motion: Motion, case: Case) -> str:
    """The motion as a table in mm and degrees; header as in CONVENTIONS."""
    from cases.recording_format import motion_columns

    limits = case.need_motion("a plan")[1]
    unit = np.where(limits.turns, 1 / DEG, 1 / MM)
    table = np.column_stack([motion.t, motion.coordinates * unit, motion.rates * unit, motion.accelerations * unit])
    return _csv(motion_columns(limits.columns), table)


def _csv(columns: Sequence[str], table: Array) -> str:
    form = ",".join(["%.9g"] * table.shape[1])
    return "\n".join([",".join(columns), *(form % tuple(row) for row in table.tolist())]) + "\n"
