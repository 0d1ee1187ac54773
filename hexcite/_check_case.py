"""Whether a case can be used: its figures, what commands miss in it, and how much of its motion box is reachable."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cases.base.phrases import Phrase
from cases.base.units import as_html
from cases.readiness import readiness
from cases.schema import Case
from cases.tables import find_case
from hexcite.reports.case_figures import case_figures, has_motion_box, leftovers, share_sentences
from hexcite.reports.collision import Kept, kept_apart
from planner.box.proposal import ProposedBox, proposed_box
from planner.box.reach import Reach
from planner.box.reach import reach as reach_of


@dataclass(frozen=True, slots=True, repr=False)
class CaseCheck:
    """A case that is valid, and what is known of it."""

    case: Case
    figures: Mapping[str, Any]  # name, title, setup and hash
    missing: Mapping[str, tuple[str, ...]]  # command -> what it misses in the case; empty where it is ready
    remarks: tuple[Phrase, ...]  # what a person should look at
    reach: Reach | None  # reachable share of the motion box; None where the case has none
    kept: Kept | None = None  # bodies and boxes that are kept apart; None where no machine is described
    proposal: ProposedBox | None = None  # a box that is within reach, where one was asked for

    def to_json(self) -> dict[str, Any]:
        """Entries for programs."""
        missing = {command: list(lacks) for command, lacks in self.missing.items()}
        phrases = [remark.to_json() for remark in self.remarks]
        answer = {"figures": dict(self.figures), "missing": missing, "remarks": list(self.remarks), "phrases": phrases}
        parts = {"reach": self.reach, "kept_apart": self.kept, "proposal": self.proposal}
        return answer | {name: part.to_json() for name, part in parts.items() if part is not None}

    def __repr__(self) -> str:
        """What it is, what it is ready for, and its reach."""
        ready = ", ".join(command for command, lacks in self.missing.items() if not lacks) or "no command"
        lines = [repr(self.case), f"ready for: {ready}"]
        for missing in dict.fromkeys(filter(None, self.missing.values())):
            commands = ", ".join(command for command, lacks in self.missing.items() if lacks == missing)
            lines.append(f"not ready for: {commands}; the case misses {', '.join(missing)}")
        lines += [f"look at {remark}" for remark in self.remarks]
        lines += [] if self.reach is None else [share_sentences(self.reach)]
        lines += [] if self.kept is None else [repr(self.kept)]
        return "\n".join([*lines, *self._proposed()])

    def _proposed(self) -> list[str]:
        """The proposal in lines."""
        box = self.proposal
        if box is None:
            return []
        if self.reach is not None and self.reach.whole:
            return ["no other box is needed: all of the stated one is within reach"]
        head = (
            f"a box of {100 * box.share:.2g} % of its volume is within reach, as far as {box.poses} poses show; sides "
            "of [limits.motion], relative to home:"
        )
        return [head, *(f"    {line}" for line in box.lines)]

    _repr_html_ = as_html


def check_case(case: Case | Path | str, propose: bool = False) -> CaseCheck:
    """Validates a case and says how much of its motion box is reachable.

    >>> hx.check_case("hexapod").missing["plan"]
    ()

    Args:
        case: a case; or built-in name, folder or case file.
        propose: whether to look for a motion box that is within reach as a whole.

    Raises:
        CaseError: the case is not valid, or the machine cannot stand at home; `problems` has all that was found.
    """
    loaded = case if isinstance(case, Case) else Case.load(str(case))
    figures = case_figures(loaded, str(find_case(loaded.origin if isinstance(case, Case) else str(case))))
    reach = reach_of(loaded) if has_motion_box(loaded) else None
    proposal = proposed_box(loaded) if propose else None
    return CaseCheck(loaded, figures, readiness(loaded), leftovers(loaded), reach, kept_apart(loaded), proposal)
