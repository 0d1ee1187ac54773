"""A force/torque sensor alone: averaged forces at standstills, with the orientation of each."""

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

import hexcite as hx

case = hx.load_case("ft_wrist")  # its sensor reads the load's pull
mass, centre = 1.2, np.array([0.0, 0.01, 0.05])  # of the load [kg, m]
offsets = np.array([3.0, -2.0, 5.0, 0.1, -0.2, 0.3])  # of the sensor [N, N m]
rotations = Rotation.random(12, random_state=0).as_matrix()  # from the sensor to the world, shape (n, 3, 3)
weights = mass * rotations.transpose(0, 2, 1) @ case.gravity  # in the sensor's axes, shape (n, 3) [N]
noise = np.random.default_rng(0).normal(scale=[0.05] * 3 + [0.002] * 3, size=(12, 6))
forces = np.hstack([weights, np.cross(centre, weights)]) + offsets + noise

names = ["fx", "fy", "fz", "tx", "ty", "tz", *(f"r{i}{k}" for i in (1, 2, 3) for k in (1, 2, 3))]
rows = np.hstack([forces, rotations.reshape(-1, 9)]).tolist()
Path("standstills.csv").write_text("\n".join([",".join(names), *(",".join(map(str, row)) for row in rows)]))

result = hx.identify(hx.read("standstills.csv", case))
print(result)
assert abs(result["m"].value - mass) < 4 * result["m"].reported
