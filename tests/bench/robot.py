"""A robot with a wrist sensor: planned moves against chance, against standstills chosen by hand, and identified.

Prints, for `ur10_wrist` and 10 s: the D-efficiency of the plan over that of the best of 100 random feasible walks of as
many moves; how long the search takes; predicted standard deviations beside those of ten standstills that turn the
flange by hand-picked angles, for the same time; coverage of the intervals over 20 runs.

Usage: python tests/bench/robot.py
"""

from time import process_time

import numpy as np

from cases.schema import load_case
from hexcite._run import execute
from hexcite._write import write
from identification.estimation.criteria import reference_scaling
from identification.identify import identify
from identification.machines.casadi_batch import over_samples
from identification.model.model import identification_model
from identification.model.parameters import nominal_parameters
from identification.simulate import truth_rows
from planner.bounds.bound import information_limit
from planner.families.ptp import PointToPointFamily
from planner.families.settings import PointToPoint
from planner.noise import expected_noise, mean_information, seen_through
from planner.plans.figures import noise_covariance
from planner.plans.making import make
from planner.plans.prediction import Prediction
from planner.request import Request
from planner.search.feasibility import keep_limits
from planner.search.parallel import run_here, silent
from tests.random_start import random_start

DURATION, WALKS, RUNS = 10.0, 100, 20
BY_HAND = np.deg2rad([
    [0, 0], [45, 0], [-45, 0], [0, 45], [0, -45], [45, 45], [45, -45], [-45, 45], [-45, -45], [20, 20]
])  # fmt: skip  # of wrist_1 and wrist_2 from home: as far as the box lets


def robot_figures() -> None:
    """Prints them."""
    case = load_case("ur10_wrist")
    model = identification_model(case, 6)
    scaling, bound = reference_scaling(case, model), information_limit(case, model)
    began = process_time()
    plan = make(Request(PointToPoint(), DURATION, model=6), case, silent, run_here)
    seconds, worth = process_time() - began, plan.of_motion[1]
    family = PointToPointFamily.of(case, PointToPoint().count(case, DURATION), DURATION)
    chance = []
    for seed in range(WALKS):
        walk = random_start(family, np.random.default_rng(seed), lambda unknowns: 1.0)
        inside, _ = keep_limits(case, family, walk, 1000.0)
        information = mean_information(model, scaling, family.motion(inside))
        chance.append(bound.efficiency(float(np.linalg.slogdet(information)[1])))
    print(f"plan: {family.moves} moves, {seconds:.0f} s of processor time, {len(worth.starts)} starts")
    print(f"D-efficiency {worth.d_efficiency:.3f}, best of {WALKS} random walks {max(chance):.3f}: ", end="")
    print(f"{worth.d_efficiency / max(chance):.1f} times")

    static = identification_model(case, 0)
    home = case.need_motion("the bench")[0]
    poses = np.tile(home, (len(BY_HAND), 1))
    poses[:, 3:5] += BY_HAND
    still = np.zeros_like(poses)
    of_static = reference_scaling(case, static)
    noise = expected_noise(case, static)
    weighted = seen_through(static, noise.whitening)
    rows = over_samples(weighted.coordinate_regressor, poses, still, still)[0].reshape(-1, len(of_static)) * of_static
    covariance = noise_covariance(case, of_static, rows.T @ rows / len(poses), DURATION, noise.sensors)
    by_hand = Prediction(static, nominal_parameters(static, case.body(0)), covariance).std
    print("standard deviations, planned beside ten standstills chosen by hand, measured as long, weighed alike:")
    for name, std in by_hand.items():
        print(f"  {name:7} {plan.predicted_std[name]:.2g} {std:.2g}")

    program = write(plan, "setpoints")
    shares = []
    for seed in range(RUNS):
        result = identify(execute(program, case, "virtual", seed)[1], case)
        assert result.estimate is not None
        shares += [abs(row["error"]) / row["std"] for row in truth_rows(case, result.estimate)]
    within = np.mean(np.array(shares) < 1.96)
    print(
        f"{RUNS} runs: {100 * within:.1f} % of the truths in their 95 % intervals, worst {max(shares):.2f} deviations"
    )


if __name__ == "__main__":
    robot_figures()
