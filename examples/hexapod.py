"""A hexapod with force sensors: plan a motion, write its program, rehearse it, identify the parameters."""

import hexcite as hx

case = hx.load_case("hexapod")
plan = hx.plan(case, hx.PointToPoint(moves=20), duration=6.0, starts=1)
program = hx.write(plan, "sinumerik")  # read back and proven, or refused with the limit
recording = hx.run(program, case, on="virtual", seed=0)  # of your machine: hx.read("run.csv", case)
result = hx.identify(recording, case)

mass, truth = result["m"], case.simulation.parameters.body.mass_kg
print(plan)
print(f"mass {mass.value:.4f} +- {mass.reported:.4f} kg, true {truth:.4f} kg")
assert abs(mass.value - truth) < 4 * mass.reported
