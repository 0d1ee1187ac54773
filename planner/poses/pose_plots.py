"""Figures of pose sets: where they lie (Figure 4), and how sharply they will determine each parameter (Table 5)."""

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from cases.schema import Case
from cases.units import MM
from identification.model import Model
from identification.parameters import body_parameters, physical_form
from planner.poses.space import places

Array = NDArray[np.float64]

ARROW = 60.0  # [mm]
SHOWN = 2000  # candidates; more make the drawing grey


def pose_figure(case: Case, candidates: Array, poses: Array) -> Figure:
    """Candidates and chosen poses in the workspace, from the side and from above; arrows: z of {P}.

    Args:
        case: gives home.
        candidates: coordinates, shape (n, c) [m or rad].
        poses: chosen, in the order of visit, shape (k, c) [m or rad].
    """
    home = places(case, case.need_motion("a plot of poses")[0][None])[0]
    candidates, poses = places(case, candidates), places(case, poses)
    figure = Figure(figsize=(12, 6), layout="constrained")
    space = figure.add_subplot(1, 2, 1, projection="3d")
    above = figure.add_subplot(1, 2, 2)
    some = (candidates[:: max(1, len(candidates) // SHOWN)] - home)[:, :3] / MM
    at = (poses - home)[:, :3] / MM
    normal = ARROW * Rotation.from_euler("xyz", poses[:, 3:]).as_matrix()[:, :, 2]
    space.scatter(*some.T, s=3, color="0.8")
    space.quiver(*at.T, *normal.T, color="C0", linewidth=1.2)
    space.scatter(*at.T, s=12, color="C3")
    space.set_zlabel("z from home [mm]")
    if case.chain is None:  # the poses of a hexapod share a height
        space.set_zlim(-150, 150)
    space.set_title(f"{len(poses)} poses chosen from {len(candidates)}")
    above.scatter(some[:, 0], some[:, 1], s=5, color="0.8", label="candidates")
    way = np.vstack([np.zeros(3), at, np.zeros(3)])
    above.plot(way[:, 0], way[:, 1], color="0.6", linewidth=0.8, label="way from home and back")
    above.quiver(at[:, 0], at[:, 1], normal[:, 0], normal[:, 1], color="C0", angles="xy", scale_units="xy",
                 scale=0.5, width=0.004, label="tilt of the z axis of {P}")  # fmt: skip
    above.scatter(at[:, 0], at[:, 1], s=14, color="C3", zorder=3, label="poses")
    reach = float(np.abs(np.vstack([some, at])[:, :2]).max()) + 1.5 * ARROW
    above.set(xlim=(-reach, reach), ylim=(-reach, reach))
    above.set_aspect("equal")
    above.grid(alpha=0.25)
    above.legend(loc="upper center", bbox_to_anchor=(0.5, -0.1), ncols=2, fontsize="small")
    for ax in (space, above):
        ax.set_xlabel("x from home [mm]")
        ax.set_ylabel("y from home [mm]")
    return figure


def density_figure(case: Case, model: Model, deviations: dict[str, float], every: dict[str, float]) -> Figure:
    """Normal density of each parameter about its nominal value, as in the last row of Table 5.

    Chosen poses in colour; in grey what all candidates together would give.

    Args:
        case: gives the nominal body; parameters without a nominal value are drawn about 0.
        model: model of the parameters.
        deviations: predicted standard deviation of each physical parameter from the chosen poses [SI].
        every: the same from all candidates.
    """
    centre = {p.name: 0.0 for p in physical_form(model).parameters}
    if case.nominal is not None:
        body = body_parameters(case.nominal)
        centre["m"] = body["m"]
        centre |= dict(zip(("xC", "yC", "zC"), case.nominal.centre_of_gravity, strict=True))
    units = {p.name: p.unit for p in physical_form(model).parameters}
    names = list(deviations)
    columns = min(5, len(names))
    rows = -(-len(names) // columns)
    figure = Figure(figsize=(2.7 * columns, 1.9 * rows), layout="constrained")
    for ax, name in zip(figure.subplots(rows, columns, squeeze=False).flat, names, strict=False):
        scale, unit = (1e3, "mm") if units[name] == "m" else (1.0, units[name])
        middle, std = centre[name] * scale, deviations[name] * scale
        x = np.linspace(middle - 4 * std, middle + 4 * std, 200)
        ax.fill_between(x, _normal_density(x, middle, every[name] * scale), color="0.8")
        ax.fill_between(x, _normal_density(x, middle, std), color="C0", alpha=0.6)
        ax.set_title(f"{name} ± {std:.2g} {unit} (all ± {every[name] * scale:.2g})", fontsize="small")
        ax.set_yticks([])
        ax.tick_params(labelsize=7)
        ax.ticklabel_format(axis="x", useOffset=False)
        ax.locator_params(axis="x", nbins=3)
    for ax in figure.axes[len(names) :]:
        ax.set_axis_off()
    return figure


def _normal_density(x: Array, mean: float, std: float) -> Array:
    return np.asarray(np.exp(-(((x - mean) / std) ** 2) / 2) / (std * np.sqrt(2 * np.pi)))
