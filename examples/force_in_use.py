"""The calibrated sensor in use: tared before a job, forces of the job, and the model for the controller."""

import hexcite as hx

case = hx.load_case("hexapod")
program = hx.write(hx.plan(case, hx.PointToPoint(moves=20), duration=6.0, starts=1), "sinumerik")
result = hx.identify(hx.run(program, case, seed=0), case)
result.save("calibration")

job = hx.run(program, case, seed=1, payload=1)  # a weight of 20 kg acts that the result does not know
external = hx.force(job, result)
print("rms of external force [N] and moment [N m]:", external.rms.round(1).tolist())
print("at most without contact:", hx.verify(hx.run(program, case, seed=2), result).force_3s_N.round(1), "N")
print("for the controller:", [file.name for file in hx.export(result, "c", "model")])
assert external.rms[:3].max() > 100.0
