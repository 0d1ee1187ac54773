"""Standing still: the poses that tell most, compared with poses of one's own, measured and averaged."""

import numpy as np

import hexcite as hx

case = hx.load_case("hexapod")
chosen = hx.plan_poses(case, count=20, candidates=120)
by_hand = hx.plan_poses(case, np.random.default_rng(0).permutation(chosen.poses)[:10])  # yours: "poses.csv"
for name, plan in (("20 chosen", chosen), ("10 of them", by_hand)):
    print(f"{name}: mass to {1e3 * plan.predicted_std['m']:.1f} g")

recording = hx.run(hx.write(chosen, "sinumerik"), case, on="virtual", seed=0)
result = hx.identify(recording, case, model=5)  # inertia cannot be seen at rest
mass, truth = result["m"], case.simulation.parameters.body.mass_kg
print(f"mass {mass.value:.3f} +- {mass.reported:.3f} kg, true {truth:.3f} kg")
assert abs(mass.value - truth) < 4 * mass.reported
