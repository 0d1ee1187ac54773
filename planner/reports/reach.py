"""The reach of a machine in words, rows and bars."""

from matplotlib.axes import Axes

from planner.precision import share_text
from planner.reach import Reach

COLUMNS = ("coordinate", "stated range", "reachable range", "limited by")


def percent(share: float) -> str:
    """A share in %, with three digits, and never 100 % where something is missing."""
    text = f"{100 * share:.3g}"
    return f"{100 * share:.6g} %" if text in ("100", "0") and share not in (0.0, 1.0) else f"{text} %"


def share_words(reach: Reach) -> str:
    """The reachable share of the box's volume; one of 0 or 1 as the bound that holds with a probability of 95 %."""
    if reach.whole:
        return "100 %"
    if reach.share == 1.0:
        return f"more than {100 * (1 - 3 / reach.poses):.2f} %"
    return f"less than {100 * 3 / reach.poses:.2g} %" if reach.share == 0.0 else percent(reach.share)


def share_sentences(reach: Reach) -> str:
    """How much of the box's volume is reachable, and which limits the rest exceeds, in a line."""
    worst = f"{share_text(reach.worst)} of the limit {reach.worst_limit}"
    poses = f"{reach.poses} random poses"
    if reach.whole:
        return f"The whole motion box is reachable: of {poses} and a search, the worst uses {worst}."
    start = f"Of the motion box's volume {share_words(reach)} is reachable"
    if reach.share == 1.0:
        return f"{start} (all of {poses}), but not every corner: the worst pose uses {worst}."
    exceeded = sorted(reach.exceeded.items(), key=lambda item: -item[1])
    kinds = ", ".join(f"{kind} in {percent(share)}" for kind, share in exceeded)
    return f"{start} (standard error {100 * reach.share_std:.2g} %, {poses}). Exceeded limits: {kinds} of the poses."


def coordinate_rows(reach: Reach) -> list[list[str]]:
    """Rows of `COLUMNS`: key of the case file, both ranges in its unit, what limits the lower and the upper end."""
    stated, reachable = ((box / reach.units).T for box in (reach.stated, reach.reachable))
    rows = []
    for key, outer, inner, names in zip(reach.keys, stated, reachable, reach.limited_by, strict=True):
        sides = [f"{side}: {name}" for side, name in zip(("below", "above"), names, strict=True) if name is not None]
        ranges = [f"[{low:.4g}, {high:.4g}]" for low, high in (outer, inner)]
        rows.append([key, *ranges, "; ".join(sides) or "the stated range"])
    return rows


def draw_coordinates(axes: Axes, reach: Reach) -> None:
    """One bar a coordinate: what is stated, and what is reachable of it with the others at home."""
    stated, reachable = ((box / reach.units).T for box in (reach.stated, reach.reachable))
    for row, (outer, inner) in enumerate(zip(stated, reachable, strict=True)):
        size = max(-outer[0], outer[1])
        for (low, high), height, colour, label in (
            (outer, 0.5, "0.85", "stated"),
            (inner, 0.25, "tab:green", "reachable, the others at home"),
        ):
            axes.barh(row, (high - low) / size, height, low / size, color=colour, label=None if row else label)
        for end, whole, side in zip(inner, outer, ("left", "right"), strict=True):
            colour = "0.2" if end == whole else "red"
            axes.text(end / size, row + 0.38, f"{end:.3g}", ha=side, va="center", fontsize="small", color=colour)
    axes.axvline(0.0, color="0.4", linewidth=0.8)
    axes.set_yticks(range(len(reach.keys)), [f"{key.split('_')[0]} [{key.split('_')[1]}]" for key in reach.keys])
    axes.set(xlim=(-1.1, 1.1), xticks=[], ylim=(len(reach.keys) - 0.3, -0.5))
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, 0.0), frameon=False, ncols=2)
    axes.set_title(f"{share_words(reach)} of the motion box reachable")
