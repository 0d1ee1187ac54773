"""Feed override of a long run, block by block: stretches that go on in the next block become one."""

from dataclasses import dataclass, field
from typing import Any

from identification.findings.feed import STEP, Piece, about_pieces, piece_of, recorded_overrides
from identification.formats.stream import Recording

MOST_TOLD = 1000  # stretches kept with their rows: memory does not grow with what a run does again and again
ADJOINING = 1.5  # sampling steps


@dataclass(slots=True)
class LongFeed:
    """What the recorded override says, in the order of time.

    Args:
        pieces: stretches of the run.
        more: stretches beyond `MOST_TOLD`.
        recorded: whether the run has such a column.
    """

    pieces: list[Piece] = field(default_factory=list)
    more: int = 0
    recorded: bool = False

    def add(self, block: Recording) -> None:
        """One block more, which begins where the last one ended."""
        self.recorded = self.recorded or block.override is not None
        for stretch in recorded_overrides(block):
            piece = piece_of(block, stretch)
            last = self.pieces[-1] if self.pieces and not self.more else None
            if last is not None and block.t is not None and len(block.t) > 1:
                step = float(block.t[1] - block.t[0])
                if piece.start - last.end < ADJOINING * step and abs(piece.scale - last.scale) < STEP:
                    longer = last.end - last.start >= piece.end - piece.start
                    scale = last.scale if longer else piece.scale
                    self.pieces[-1] = Piece(last.start, piece.end, last.first, piece.last, scale)
                    continue
            if len(self.pieces) < MOST_TOLD:
                self.pieces.append(piece)
            else:
                self.more += 1

    def told(self) -> tuple[list[str], dict[str, Any]]:
        """Sentences for people and entries for programs; empty where the run went at 100 %."""
        return about_pieces(self.pieces, "the recorded override", self.more)
