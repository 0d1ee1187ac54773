"""By hand or optimised, with jerk or without: plans beside each other before a machine moves."""

import hexcite as hx

case = hx.load_case("hexapod")
plans = {
    "by hand": hx.plan(case, hx.Manual()),
    "moves": hx.plan(case, hx.PointToPoint(moves=20), duration=6.0, starts=1),
    "moves for LinuxCNC": hx.plan(
        case, hx.PointToPoint(moves=20, controller="linuxcnc", without="jerk"), duration=6.0, starts=1
    ),
}
for name, plan in plans.items():
    plan.save(name)
    print(f"{name:20}{plan.duration:6.1f} s, mass to {1e3 * plan.predicted_std['m']:.1f} g")
comparison = hx.compare(list(plans))
print(comparison)
hx.report(comparison, "comparison.html")
