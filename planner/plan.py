"""A plan: the chosen motion, how it was found, what it promises and that it was proven. Saved as a folder."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cases.basis import KEPT, plan_basis
from cases.files import PLAN, atomic_folder, json_text
from cases.recording_columns import MOTION
from cases.schema import Case
from cases.units import DEG, MM
from identification.limits import LimitReport, Status
from identification.motion import Motion, Trajectory, sample
from identification.noise.pose_field import PoseField
from planner.bounds.kept import Bound
from planner.families.fourier import FourierFamily
from planner.families.fourier_motion import FourierMotion, needless_harmonics
from planner.families.saved import motion_entries
from planner.families.spline import enough_intervals
from planner.noise import ExpectedNoise
from planner.request import Request
from planner.search.last_words import solver_text
from planner.search.solving import DRAWN_BACK, Failed, Start
from planner.target import parse_targets
from planner.vibration import BothLaws

Array = NDArray[np.float64]

SCHEMA_VERSION = 1
RIVALS = 1.02  # times the D-efficiency of a plan, from which another family is worth a word
FULL = 0.9  # share of a limit that a good motion uses of at least one
_PLACES = ("position", "angle", "workspace position", "strut length", "singularity", "base joint angle",
           "platform joint angle")  # limits of where the platform is, not of how it moves  # fmt: skip
BINDING = 0.99  # share of a limit from which it shapes the motion
FEW_KNOTS = 0.9  # of as many as the jerk limits allow a spline to use: with fewer, more are worth their blocks
SAMPLE_RATE = 1000.0  # [1/s] of motion.csv


@dataclass(frozen=True, slots=True)
class Plan:
    """A planned excitation.

    Args:
        case: what it was planned for.
        case_file: name or file of the case, to find it again.
        request: what was asked for.
        motion: the excitation.
        family: name of the family that the motion comes from.
        settings: of the family.
        starts: every start that led somewhere, the best first.
        failed: the others, with the reason.
        interrupted: whether Ctrl-C ended the search early.
        score: the criterion of Table 4, to be maximised, in reference scaling.
        logdet: log det of the mean information, reference scaling, W = 1.
        condition: mu_1 / mu_u, reference scaling.
        bound: what no motion can exceed.
        predicted_std: standard deviation of each physical parameter for one run [SI].
        worst_payload: number of payloads with which that is so large, where a range was asked for.
        noise: of a force sample behind it, and how identification will weigh.
        noise_note: what noise of the accelerations does to it.
        limits: proof.
        solve_seconds: time spent on optimising [s].
        tight: what no motion from rest to rest with limited jerk can exceed, where that is known.
        rival: what another family found in seconds.
        laws: what the time law of point-to-point moves costs on a machine that is not stiff.
    """

    case: Case
    case_file: str
    request: Request
    motion: Trajectory
    family: str
    settings: dict[str, Any]
    starts: tuple[Start, ...]
    failed: tuple[Failed, ...]
    interrupted: bool
    score: float
    logdet: float
    condition: float
    bound: Bound
    predicted_std: dict[str, float]
    worst_payload: dict[str, int]
    noise: ExpectedNoise
    noise_note: tuple[str, ...]
    limits: LimitReport
    solve_seconds: float
    tight: Bound | None = None
    rival: Start | None = None
    laws: BothLaws | None = None

    @property
    def d_efficiency(self) -> float:
        """D-efficiency against the box bound."""
        return self.bound.efficiency(self.logdet)

    @property
    def d_efficiency_tight(self) -> float | None:
        """D-efficiency against the bound of motions from rest to rest, where that is known."""
        return self.tight.efficiency(self.logdet) if self.tight is not None else None

    @property
    def weaknesses(self) -> list[str]:
        """Why another plan would carry more information, each with what to do; the first thing that a user is told."""
        told = []
        if self.rival is not None and self._of_rival > RIVALS:
            counted = "" if self.case.sensors.pose_error_N is None else ", errors of the pose counted"
            told.append(
                f"weaker than a motion of another family that took seconds: --family {self.rival.family.name} has "
                f"{self._of_rival:.2f} times the D-efficiency{counted}"
            )
        refined = [s for s in self.starts if s.refined]
        if refined and not self.interrupted and not refined[0].converged:
            told.append(
                f"the search had not converged where it ended ({solver_text(refined[0].status)}): more --seconds or "
                "--starts may find more"
            )
        if self.starts and (share := self.starts[0].shrunk) < DRAWN_BACK:
            told.append(
                f"the motion had to be drawn to {100 * share:.0f} % of its ways to satisfy every limit: plan with "
                f"another --seed, or in a smaller box (hexcite case check {self.case_file} --propose)"
            )
        used = [c for c in self.limits.checks if c.binding and c.name.split(" (")[0] not in _PLACES]
        if self.starts and used and (most := max(used, key=lambda c: c.ratio)).ratio < FULL:
            told.append(
                f"no limit of speed or force is used beyond {100 * most.ratio:.0f} % ({most.name}): another --seed, "
                "more --seconds or a smaller box may find more"
            )
        return told

    @property
    def _of_rival(self) -> float:
        """D-efficiency of the other family's motion in units of this one's, with the weights of the search."""
        if self.rival is None or not self.starts:
            return 0.0
        return float(np.exp((self.rival.logdet - self.starts[0].logdet) / self.bound.parameters))

    @property
    def bound_by(self) -> list[str]:
        """The limits that shape the motion."""
        return [c.name for c in self.limits.checks if c.binding and c.ratio > BINDING]

    @property
    def notes(self) -> list[str]:
        """What the user should know before running it."""
        notes = []
        if isinstance(self.motion, FourierMotion) and (needless := needless_harmonics(self.motion)):
            order = max(2, self.motion.order - needless)
            if order < self.motion.order:
                which = "highest harmonic is" if needless == 1 else f"{needless} highest harmonics are"
                notes.append(f"the {which} negligible: --order {order} would do")
        if self.starts and self.bound_by:
            notes.append(f"shaped by these limits: {', '.join(self.bound_by)}")
        if steps := [c for c in self.limits.checks if c.status is Status.STEPS]:
            limits = ", ".join(f"{abs(c.limit):.4g} {c.unit}" for c in steps)
            notes.append(
                f"made for {self.settings.get('made_for')}, which does not limit jerk: accelerations step, and the "
                f"limits of jerk of the case ({limits}) do not count"
            )
        if self.laws is not None:
            notes.append(self.laws.sentence)
        tried = {(s.family.order, s.family.period) for s in self.starts if isinstance(s.family, FourierFamily)}
        if len(tried) > 1:
            own = f"order {self.settings['order']} with period {self.settings['period_s']:g} s"
            notes.append(f"{own} is the best of {len(tried)} choices of order and period")
        if (method := self.settings.get("retimed_with")) is not None:
            before, off_mm, off_deg = (
                float(self.settings[k]) for k in ("duration_before_s", "off_path_mm", "off_path_deg")
            )
            off = f", up to {off_mm:.2g} mm and {off_deg:.2g} deg off its path" if off_mm or off_deg else ""
            notes.append(f"re-timed with {method}: {self.motion.duration:.2f} s instead of {before:.2f} s{off}")
        if self.request.targets:
            targets = parse_targets(self.request.targets, self.case, self.request.model)
            notes.append(f"targets: {', '.join(t.compared(self.predicted_std) for t in targets)}")
        if self.family == "spline" and (knots := self.settings.get("knots")) is not None:
            enough = enough_intervals(self.case, self.motion.duration)
            if knots < FEW_KNOTS * enough:
                notes.append(
                    f"{knots} knots, not the machine, keep accelerations from their limits: --knots {enough} carries "
                    "more information"
                )
        if len(self.request.payloads) > 1:
            notes.append(f"predicted standard deviations are the largest with {self.request.mounted}: {self._by_load}")
        forces = [c for c in self.limits.checks if c.name.startswith("sensor force") and c.ratio > BINDING]
        notes += [f"{c.name} shapes the motion: with fewer weights in [payloads] it could tell more" for c in forces]
        return [*notes, *self.noise_note]

    @property
    def _by_load(self) -> str:
        """Which number of payloads makes which parameters uncertain."""
        by_load = {n: [p for p, worst in self.worst_payload.items() if worst == n] for n in self.request.payloads}
        return "; ".join(f"with {n} those of {', '.join(names)}" for n, names in by_load.items() if names)

    def _rival(self) -> dict[str, Any] | None:
        if self.rival is None:
            return None
        return {"family": self.rival.family.name, "d_efficiency": self._of_rival * self.d_efficiency}

    def to_json(self) -> dict[str, Any]:
        """What `plan.json` holds."""
        first, last = self.motion.at([0.0, self.motion.duration]).pose
        return {
            "schema_version": SCHEMA_VERSION,
            "case": self.case.name,
            "case_file": self.case_file,
            "case_hash": self.case.hash,
            KEPT: plan_basis(self.case, self.request.payload),
            "family": self.family,
            "criterion": self.request.criterion,
            "model": self.request.model,
            "status": "proven",
            "interrupted": self.interrupted,
            "duration_s": self.motion.duration,
            "first_pose_m_rad": first.tolist(),
            "last_pose_m_rad": last.tolist(),
            "settings": {**self.settings, "seed": self.request.seed},
            "solve_s": self.solve_seconds,
            "starts": [
                {
                    "seed": s.seed,
                    "refined": s.refined,
                    "start_logdet": s.start_logdet if np.isfinite(s.start_logdet) else None,
                    "logdet": s.logdet,
                    "criterion_value": s.score,
                    "solver": s.status,
                    "converged": s.converged,
                    "iterations": s.iterations,
                    "seconds": s.seconds,
                }
                for s in self.starts
            ],
            "failed_starts": [{"seed": f.seed, "reason": f.reason} for f in self.failed],
            "criterion_value": self.score,
            "logdet": self.logdet,
            "condition": self.condition,
            "d_efficiency": self.d_efficiency,
            "d_efficiency_tight": self.d_efficiency_tight,
            "bound": self.bound.to_json(),
            "bound_tight": self.tight.to_json() if self.tight is not None else None,
            "predicted_std": self.predicted_std,
            "payload": self.request.payload,
            "payload_from": self.request.payloads[0],
            "weaknesses": self.weaknesses,
            "rival": self._rival(),
            "vibration": None if self.laws is None else self.laws.to_json(),
            "notes": self.notes,
            "targets": list(self.request.targets),
            "bound_by": self.bound_by,
            "assumed_noise_N": self.noise.sensors,
            "assumed_rate_Hz": self.case.recording.rate_Hz,
            "assumed_noise_of_channels": self.noise.std.tolist(),
            "noise_of_accelerations": self.noise.shaken,
            "pose_errors": None if (field := PoseField.of(self.case.sensors)) is None else field.keys,
            "weights": self.noise.weights,
            "limits": self.limits.to_json(),
            **motion_entries(self.motion),
        }


def save_plan(plan: Plan, folder: Path, overwrite: bool = False, plots: bool = False) -> None:
    """Writes a plan folder: plan.json, motion.csv, report.html; where asked for, figures for papers in plots/."""
    from planner.comparison.beside_manual import beside_manual
    from planner.reports.page import render
    from planner.reports.plan import plan_page

    motion = sample(plan.motion, SAMPLE_RATE)
    with atomic_folder(folder, PLAN, overwrite) as part:
        (part / "plan.json").write_text(json_text(plan.to_json()), encoding="utf-8")
        (part / "motion.csv").write_text(motion_csv(motion), encoding="utf-8")
        page = plan_page(plan, beside_manual(plan) if plan.family != "manual" else "it is the motion itself")
        (part / "report.html").write_text(render(page), encoding="utf-8")
        if plots:
            from planner.reports.plots import save_figure, trajectory_figure  # Matplotlib takes a second

            save_figure(trajectory_figure(motion, plan.case), part / "plots", "trajectory")


def motion_csv(motion: Motion) -> str:
    """The motion as a table in mm and degrees; header as in CONVENTIONS."""
    unit = np.r_[np.full(3, 1 / MM), np.full(3, 1 / DEG)]
    table = np.column_stack([motion.t, motion.pose * unit, motion.rates * unit, motion.accelerations * unit])
    form = ",".join(["%.9g"] * table.shape[1])
    lines = [form % tuple(row) for row in table.tolist()]
    return "\n".join([",".join(MOTION), *lines]) + "\n"
