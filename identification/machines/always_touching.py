"""Bodies of a chain that touch wherever its joints stand: of a wrist whose links lie in each other."""

from itertools import combinations

import casadi as ca
import numpy as np

from cases.base.convex import separation
from cases.base.units import MM, Array
from cases.chain import Chain
from identification.machines.casadi_batch import over_samples
from identification.machines.clearance import bodies_of, points_of
from identification.machines.serial_chain import SerialChain

STATES = 256  # of the joints that are looked at
ENDLESS = np.pi  # [rad] to either side of 0 where a joint has no ends
LONG = 500.0 * MM  # [m] the same


def always_touching(chain: Chain) -> tuple[tuple[str, str], ...]:
    """Names of bodies that the chain keeps apart, but that touch in each of `STATES` seeded states of all joints."""
    q = ca.SX.sym("q", len(chain.joints))
    bodies = bodies_of(chain, SerialChain(chain).frames(q))
    hulls = [ca.densify(ca.vec(points_of(frame, body))) for _, frame, body in bodies]
    corners = over_samples(ca.Function("hulls", [q], hulls, {"cse": True}), _states(chain)) if hulls else []
    placed = [
        (link, body, points.reshape(STATES, -1, 3)) for (link, _, body), points in zip(bodies, corners, strict=True)
    ]
    return tuple(
        (body.name, other.name)
        for (link, body, points), (other_link, other, others) in combinations(placed, 2)
        if chain.keeps_apart(link, body.name, other_link, other.name)
        and np.all(separation(points, others) <= body.beyond + other.beyond)
    )


def _states(chain: Chain) -> Array:
    """Seeded states of all joints between their ends, shape (STATES, n) [rad or m]."""
    far = np.array([ENDLESS if joint.turns else LONG for joint in chain.joints])
    low, high = np.where(np.isfinite(chain.position), chain.position, [-far, far])
    return np.random.default_rng(0).uniform(low[:, None], high[:, None], (len(far), STATES)).T
