"""What was added to a machine: the difference of two results, in which offsets and deformation cancel."""

import hexcite as hx

case = hx.load_case("hexapod")
plan = hx.plan(case, hx.PointToPoint(moves=20), duration=6.0, starts=1, payload=1, payload_from=0)
program = hx.write(plan, "sinumerik")
empty, loaded = (hx.identify(hx.run(program, case, payload=n, seed=n), case) for n in (0, 1))
payload = hx.payload(empty, loaded)

mass, weight = payload.parameters["m"], case.payloads.weights[0].mass_kg
print(payload)
print(f"{mass.value:.4f} +- {mass.reported:.4f} kg were added, weighed {weight:.4f} kg")
assert abs(mass.value - weight) < 4 * mass.reported
