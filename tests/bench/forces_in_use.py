"""Parameters in use on machines off their cases: are offsets, forces, payloads and chains off by what is reported?

python tests/bench/forces_in_use.py        # 24 drawn machines and the built-in ones, noise of four kinds
python tests/bench/forces_in_use.py 8      # fewer
python tests/bench/forces_in_use.py 12 --of hexapod ur10_wrist --first 92000      # so many truths of each of these
"""

import argparse
import itertools
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))  # started as a script: tests is not an installed package

from cases.base.errors import HexciteError
from cases.schema import Case
from identification.identify import identify
from identification.recording.recording import Recording
from identification.results.chain_uncertainty import anywhere
from identification.results.force import force
from identification.results.frames import place_of
from identification.results.payload import payload
from identification.results.result import Result
from identification.results.taring import tare
from tests.bench.silent import MACHINES, NOISES, drawn_machines, way_of
from tests.bench.tolerances import KINDS, case_off
from tests.damaged.runs import SOUND, Change, Machine, Noise, machine, recorded
from tests.machines_in_numpy import Body

FRAMES = ("sensor", "base", "flange")
HELD = np.array([40.0, -25.0, 30.0, 3.0, -2.0, 1.5])  # what sensors hold against a force from outside, along {P}


@dataclass(frozen=True)
class Still:
    """A machine that stands at coordinates."""

    place: np.ndarray
    duration: float = 2.0

    def __call__(self, t: np.ndarray) -> np.ndarray:
        return np.broadcast_to(self.place, (len(t), len(self.place)))


class Machined(NamedTuple):
    """A machine, and how it is off its case."""

    of: Machine
    case: Case  # off by tolerances that it states
    gains: np.ndarray  # shape (6,)
    zeros: np.ndarray  # of joints, shape (k,) [rad]
    noise: Noise

    @classmethod
    def drawn(cls, name: str, seed: int, kind: str) -> "Machined":
        of, draw = machine(name), np.random.default_rng(seed)
        case = case_off(of, draw)
        gains = draw.normal(0.0, case.tolerances.gain_percent.deviation / 100.0, 6)
        zeros = np.zeros(1)
        if case.tolerances.joint_zeros_deg is not None:
            turns = np.array([joint.turns for joint in case.chain.joints])
            zeros = turns * np.radians(draw.normal(0.0, case.tolerances.joint_zeros_deg.deviation, len(turns)))
        return cls(of, case, gains, zeros, NOISES[kind])

    def run(self, way, seed: int, change: Change = SOUND) -> Recording:
        """What its recorder writes on a way."""
        run = recorded(self.of, way, seed, self.noise, change)
        return replace(run, forces=run.forces * (1.0 + self.gains), drives=run.drives + self.zeros, case=self.case)

    def still(self, seed: int, seconds: float = 2.0) -> Recording:
        """A standstill somewhere."""
        half, draw = self.of.limits[0], np.random.default_rng(seed)
        return self.run(Still(self.of.home + 0.5 * half * draw.uniform(-1.0, 1.0, len(half)), seconds), seed)


def tare_errors(of: Machined, result: Result, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Errors of offsets tared at one pose over their reported deviations, and in the covariance of all of u."""
    tared = tare(of.still(seed), result)
    names = [name for name in tared.parameters if name.startswith("f_q0")]
    truth = of.of.truth
    off = np.array([(tared[name].value - truth[name]) / tared[name].reported for name in names])
    return off, np.array([result[name].reported / tared[name].reported for name in names])


def force_errors(of: Machined, result: Result, seed: int, frame: str) -> np.ndarray:
    """Errors of an external force over deviations, at instants that are far apart, shape (n, 6)."""
    way = way_of(of.of, seed + 7, 3.0)
    pulled = Change(pull=lambda now: np.broadcast_to(HELD, (len(now.q), 6)))
    found = force(of.run(way, seed + 5, pulled), result, frame=frame)
    t = found.t - of.noise.delay
    rows = np.arange(5, len(t) - 5, max(len(t) // 12, 1))
    true = np.broadcast_to(-HELD, (len(rows), 6))
    if frame == "base":
        turn = of.of.plant.motion(way, t[rows]).turn
        true = np.hstack([np.einsum("nij,nj->ni", turn, true[:, half]) for half in (slice(0, 3), slice(3, 6))])
    elif frame == "flange":
        place = of.of.case.flange_from_sensor
        turned = np.hstack([true[:, :3] @ place[:3, :3].T, true[:, 3:] @ place[:3, :3].T])
        true = turned + np.hstack([0.0 * turned[:, :3], np.cross(place[:3, 3], turned[:, :3])])
    return (found.wrench[rows] - true) / found.std[rows]


def payload_errors(of: Machined, result: Result, seed: int) -> np.ndarray:
    """Errors of a body that was mounted after the result, a third of the load, over deviations, shape (10,)."""
    load = of.of.plant.body
    size = float(np.cbrt(np.linalg.det(load.inertia / load.mass) ** 0.5))  # length of which its inertia is
    added = Body(load.mass / 3.0, load.centre + size * np.array([0.3, -0.2, 0.5]), load.inertia / 8.0)
    both = load.mass + added.mass
    centre = (load.mass * load.centre + added.mass * added.centre) / both
    inertia = np.zeros((3, 3))
    for body in (load, added):
        arm = body.centre - centre
        inertia += body.inertia + body.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    loaded = replace(of.of.plant, body=Body(both, centre, inertia))
    run = of.run(way_of(of.of, seed + 11, 4.0 + seed % 3), seed + 11, Change(plant=loaded))
    found = payload(result, identify(run, of.case)).parameters
    true = {"m": added.mass} | {f"{axis}C": float(v) for axis, v in zip("xyz", added.centre, strict=True)}
    true |= {f"IC{i + 1}{j + 1}": float(added.inertia[i, j]) for i in range(3) for j in range(i, 3)}
    return np.array([(found[name].value - value) / found[name].reported for name, value in true.items()])


def chain_errors(of: Machined, result: Result, seed: int) -> np.ndarray:
    """Errors of forces over half of the U that an exported chain states anywhere in the motion box, shape (n, 6)."""
    pulled = Change(pull=lambda now: np.broadcast_to(HELD, (len(now.q), 6)))
    found = force(of.run(way_of(of.of, seed + 9, 3.0), seed + 9, pulled), result)
    promise = anywhere(result, place_of(result.case_as_told, "sensor", at_home=False)).of(-HELD)
    return (found.wrench[:: max(len(found.t) // 24, 1)] + HELD) / (promise / 2.0)


def figures(errors: list[np.ndarray]) -> str:
    size = np.abs(np.concatenate([e.ravel() for e in errors]))
    inside, beyond = np.mean(size < 1.96), np.mean(size > 3.0)
    return f"rms {np.sqrt(np.mean(size**2)):.2f}, within 1.96: {100 * inside:.1f} %, beyond 3: {100 * beyond:.1f} %"


def main() -> None:
    """Prints each machine, then all."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("count", type=int, nargs="?", default=24)
    parser.add_argument("--of", nargs="*", help="names of machines, of each of which so many truths are drawn")
    parser.add_argument("--first", type=int, default=91_000, help="seed of the first")
    asked = parser.parse_args()
    names = [*itertools.islice(drawn_machines(asked.first), asked.count), *MACHINES]
    if asked.of:
        names = [name for _ in range(asked.count) for name in asked.of]
    every: dict[str, list[np.ndarray]] = {}
    for seed, name in enumerate(names, asked.first):
        kind = KINDS[(seed // len(asked.of) if asked.of else seed) % len(KINDS)]
        try:
            of = Machined.drawn(name, seed, kind)
            result = identify(of.run(way_of(of.of, seed, 4.0 + seed % 3), seed), of.case)
            off, narrower = tare_errors(of, result, seed + 3)
            errs = {"tared offsets": off, "payload": payload_errors(of, result, seed)}
            for frame in FRAMES:
                if frame == "flange" and (of.case.chain is None or of.case.flange_from_sensor is None):
                    continue
                errs[f"force, {frame}"] = force_errors(of, result, seed, frame)
            errs["exported chain"] = chain_errors(of, result, seed)
            each = ", ".join(f"{what} {np.sqrt(np.mean(err**2)):.2f}" for what, err in errs.items())
            print(f"{name} | {kind} | {each} | offsets {narrower.mean():.2f} times narrower", flush=True)
            for what, err in errs.items():
                for of_what in (what, f"{what} of {name}") if asked.of else (what,):
                    every.setdefault(of_what, []).append(err)
        except HexciteError as error:
            print(f"{name} | {kind} | {type(error).__name__}: {error}", flush=True)
    for what, all_errors in sorted(every.items()):
        print(f"{what}: {figures(all_errors)}")


if __name__ == "__main__":
    main()
