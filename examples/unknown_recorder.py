"""A file that some recorder wrote: what its columns are, proposed and tried, and written into a case."""

from pathlib import Path

import numpy as np

import hexcite as hx

case = hx.load_case("hexapod")
program = hx.write(hx.plan(case, hx.PointToPoint(moves=20), duration=6.0, starts=1), "sinumerik")
run = hx.run(program, case, seed=0)
names = ["Zeit [ms]", *(f"Strebe {k} [m]" for k in range(1, 7)), *(f"Kraft {k} [N]" for k in range(1, 7)), "Trigger"]
rows = np.column_stack([run.t * 1e3, run.drives, run.forces, run.trigger])
lines = [";".join(names), *(";".join(f"{value:.9g}" for value in row).replace(".", ",") for row in rows)]
Path("run.csv").write_text("\n".join(lines) + "\n")

seen = hx.look("run.csv")
print(seen)  # each column with its unit, and what is doubtful
print(seen.toml)  # the table [recording] of a case
assert seen.problem is None
