"""A robot with a force/torque sensor at its flange: a plan in its joints, a trajectory, the load."""

import hexcite as hx

case = hx.load_case("ur10_wrist")  # yours: hx.new_arm("arm", "robot.urdf", "tool0")
plan = hx.plan(case, hx.PointToPoint(), duration=6.0, starts=1)
program = hx.write(plan, "ros2")
program.save("trajectory.yaml")
recording = hx.run(program, case, on="virtual", seed=0)
result = hx.identify(recording, case)
files = hx.export(result, "urscript", "load.script", overwrite=True)

mass, truth = result["m"], case.simulation.parameters.body.mass_kg
print(f"mass {mass.value:.4f} +- {mass.reported:.4f} kg, true {truth:.4f} kg; written: {files[0].name}")
assert abs(mass.value - truth) < 4 * mass.reported
