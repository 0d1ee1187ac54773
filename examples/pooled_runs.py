"""Several runs of one machine as one result, and whether one of them differs from the others."""

import hexcite as hx

case = hx.load_case("hexapod")
program = hx.write(hx.plan(case, hx.PointToPoint(moves=20), duration=6.0, starts=1), "sinumerik")
results = [hx.identify(hx.run(program, case, seed=seed), case) for seed in range(3)]
pooled = hx.pool(results)

for result in (*results, pooled):
    print(f"mass {result['m'].value:.4f} +- {result['m'].reported:.4f} kg")
for finding in pooled.findings:
    print(finding.sentence)
assert pooled["m"].reported < min(result["m"].reported for result in results)
