"""Plans, runs and results side by side, with a recommendation that follows from them."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cases.errors import HexciteError
from cases.files import COMPARISON, atomic_folder, check_folder, json_text
from cases.schema import Case
from planner.comparison.advising import Recommendation, groups, recommend, warnings_of
from planner.comparison.entries import Entry, entry_of_plan, read_entry
from planner.plan import Plan


@dataclass(frozen=True, slots=True, repr=False)
class Comparison:
    """Excitations before and after running them.

    Args:
        groups: what belongs together: a plan, its runs and their results.
        advice: which one to prefer.
    """

    groups: tuple[tuple[Entry, ...], ...]
    advice: Recommendation

    @property
    def entries(self) -> list[Entry]:
        """All that is compared, in the order of the groups."""
        return [entry for group in self.groups for entry in group]

    @property
    def warnings(self) -> tuple[str, ...]:
        """What keeps figures from being compared."""
        return warnings_of(self.entries)

    def to_json(self) -> dict[str, Any]:
        """What `comparison.json` holds."""
        return {
            "rows": [e.to_json() for e in self.entries],
            "groups": [[e.name for e in g] for g in self.groups],
            "recommendation": self.advice._asdict(),
            "warnings": list(self.warnings),
        }

    def write(self, folder: Path) -> None:
        """Writes comparison.json into a folder that is there."""
        (folder / "comparison.json").write_text(json_text(self.to_json()), encoding="utf-8")

    def save(self, folder: Path | str, overwrite: bool = False) -> None:
        """Makes a folder with comparison.json."""
        check_folder(Path(folder), COMPARISON, overwrite=overwrite)
        with atomic_folder(Path(folder), COMPARISON, overwrite) as part:
            self.write(part)

    def __repr__(self) -> str:
        """What is compared, and the recommendation."""
        names = ", ".join(entry.name for entry in self.entries)
        return "\n".join([f"Comparison of {names}", *self.advice.sentences])


def compare(things: Sequence[Plan | Path | str], case: Case | None = None, stale: bool = False) -> Comparison:
    """Cost, information and standard deviations side by side, and which excitation to prefer.

    A result belongs to the run it was made of, a run to the plan whose path it followed.

    Args:
        things: plans, and folders of plans, poses, runs and results, in any mix.
        case: instead of the one that a folder names.
        stale: go on although a case has changed since.

    Raises:
        HexciteError: one cannot be used, or is named twice.
    """
    folders = [Path(thing) for thing in things if not isinstance(thing, Plan)]
    for k, folder in enumerate(folders):
        if any(folder.resolve() == other.resolve() for other in folders[:k]):
            raise HexciteError(f"{folder}: is named twice; name each folder once")
    entries = [
        entry_of_plan(thing, thing.name) if isinstance(thing, Plan) else read_entry(Path(thing), case, stale)
        for thing in things
    ]
    found = groups(entries)
    return Comparison(tuple(tuple(group) for group in found), recommend(found))
