"""Reads SINUMERIK 840D sl / ONE programs as the controller would, as far as an excitation needs; all else is refused.

Words: 840D sl / ONE programming manuals; the orientation words, the transformation and the trigger's output are those
of the case. In a machine's own axes no transformation is active, and moves go from rest to rest.
"""

import re
from collections.abc import Sequence

import numpy as np

from cases.base.units import MINUTE
from cases.controller import SINUMERIK_NAME, Sinumerik, SinumerikAxes
from cases.schema import Case
from postprocessors.dialects.modal import LARGEST, ModalState, Word
from postprocessors.reading import NUMBER, PLAIN, Reading, TimedBlock, axis_letters, program_lines

LONGEST_LINE = 512
SAME_RADIUS = 1e-5  # [mm] tolerance of the radius of FGREF
MM_A_DEGREE = 180.0 / np.pi
_READS = (
    "SINUMERIK programs consist of G1 under G60 (of a platform also arcs, and POLY or COMPCAD under G93), G4 F, the "
    "case's DO $A_OUT[n]=1 and =0, $AN_SLTRACE=1 and =2, M0, modal words as hexcite post writes them, comments "
    "behind ; and M30"
)
_TRACE = "$AN_SLTRACE="  # 1 and 2 start and stop a trace whose triggers are this variable
_HARMLESS = re.compile(r";(?!\s*\$)|;\$PATH=/_N_(?:MPF|WKS)_DIR[A-Z0-9_/]*\s*$", re.IGNORECASE)
_OF_OWN_AXES = {"G1", "G17", "G40", "G60", "G90", "G94", "G500", "G710", "COMPOF", "SOFT", "FFWON", "DYNNORM"}


class SinumerikInterpreter(ModalState):
    """Meaning of the words."""

    name, last, reads, feed_group = "SINUMERIK", ("M30", "M2"), _READS, "FGROUP({})"
    title = re.compile(rf"%_N_(?:{SINUMERIK_NAME[1:-1]})_MPF\s*$", re.IGNORECASE)
    word = re.compile(
        rf"""(?P<comment>;.*)
        | (?P<action>DO)\s+(?P<assignment>[^\s;][^;]*)
        | (?P<piece>PO\[[A-Z0-9_]+\])\s*=\s*\(\s*(?P<items>{NUMBER}(?:\s*,\s*{NUMBER})*)\s*\)
        | (?P<assigned>FGREF\[[A-Z]\]|\$AN_SLTRACE|[A-Z]+\d*)\s*=\s*(?P<value>{NUMBER})
        | (?P<text>MSG)\s*\((?:"[^"]*")?\)
        | (?P<keyword>[A-Z_]{{2,}}[A-Z0-9_]*)(?:\((?P<arguments>[A-Z0-9_,.\s]*)\))?
        | (?P<letter>[A-Z])(?P<number>{NUMBER})""",
        re.IGNORECASE | re.VERBOSE,
    )
    home_check = re.compile(
        rf"IF (?P<two>\()?ABS\(\$AA_IW\[(?P<axis>[A-Z]+\d*)\](?P<place>[+-]{PLAIN})\)>(?P<within>{PLAIN})"
        r"(?(two)\) OR \(ABS\(\$AA_IB\[(?P=axis)\](?P=place)\)>(?P=within)\))\n"
        rf'MSG\("[^"\n]*"\)\nSETAL\(65\d\d\d,"[^"\n]*"\)\nM30\nENDIF'
    )
    home_check_lines, condition, asks_where = 5, "IF", "STOPRE"
    resolution = 1e-3  # the usual increments (MD10200, MD10210)
    groups = (
        *("G0 G1 G2 G3 POLY", "G17 G18 G19", "G93 G94", "G60 G64 G642", "COMPOF COMPCAD"),
        *("G90", "G710", "G40", "G500", "SOFT", "FFWON", "DYNNORM", "ORIWKS", "ORIRPY", "ORIAXES", "M0 M1 M2 M30"),
    )

    def __init__(self, file: str, settings: SinumerikAxes, case: Case) -> None:
        self.settings = settings
        self.of_pose = settings if isinstance(settings, Sinumerik) else None  # None: in the machine's own axes
        if self.of_pose is not None:
            words = self.of_pose.orientation_words
            axes = ["X", "Y", "Z", *(w + "=" if w[-1].isdigit() else w for w in words)]
            rpy = ["ORIWKS", "ORIRPY"] if any(w[-1].isdigit() for w in words) else []
            needed = ["ORIAXES", *rpy, self.of_pose.transformation]
        else:
            axes = list(axis_letters(case, "SINUMERIK", file, endless=False))
            needed = ["TRAFOOF", "COMPOF", "G94", *(f"FGREF[{axis}]=" for axis in axes if axis in "ABC")]
        super().__init__(file, axes, self.of_pose is None)
        self.needed = {word: (word,) for word in ("G90", "G710", "G40", "G500", "D0", "TRANS", "SOFT", *needed)}
        if self.of_pose is not None:
            self.angles = self.of_pose.orientation_axes
        self.needed |= {"G60": ("G60",)} if self.own_axes else {"G60 or G64": ("G60", "G64", "G642")}

    def axes_of_places(self) -> Sequence[str]:
        """Names of the axes, also of those behind words of angles."""
        return self.axes if self.of_pose is None else ("X", "Y", "Z", *self.of_pose.orientation_axes)

    @classmethod
    def comment_problem(cls, text: str, match: re.Match[str]) -> tuple[str, str] | None:
        """`;$PATH=` says into which folder a file is read: in that of cycles it would replace the builder's."""
        if _HARMLESS.match(match["comment"]):
            return None
        return f"the control may act on {match['comment'][:40]!r}", "write ;$PATH=/_N_MPF_DIR, or remove it"

    @classmethod
    def word_of(cls, match: re.Match[str], column: int) -> Word:
        """The word of a match of `word`."""
        if match["letter"]:
            return super().word_of(match, column)
        if match["assigned"]:
            return Word(match["assigned"].upper() + "=", column, float(match["value"]))
        name = match["action"] or match["piece"] or match["text"] or match["keyword"]
        arguments = "".join((match["assignment"] or match["items"] or match["arguments"] or "").upper().split())
        return Word(name.upper(), column, None, tuple(arguments.split(",")) if arguments else ())

    def read(self, block: dict[str, Word]) -> None:
        """Executes the words of one block, by their names."""
        for word in block.values():
            self._word(word, block)
        if "G4" in block:
            self.require_alone(block["G4"], block, "F")
            self.pause(block["G4"], block.get("F"), "G4 F0.3", switches=True)
        else:
            self._move(block)
        if end := next((word for name, word in block.items() if name in self.last), None):
            self.end(end, "" if self.of_pose is None else self.of_pose.transformation_off)

    def _word(self, word: Word, block: dict[str, Word]) -> None:
        name, s = word.name, self.of_pose
        if name in ("%", "MSG", "G4", "F", *self.last, *self.axes):
            return
        if name == "TRANS" or (name == "D" and word.value == 0.0):
            self.require_alone(word, block)
            self.said.add(word.written)
            return
        if name in (_TRACE, "STOPRE"):
            self._outside_motion(word, block)
            return
        if name in (_OF_OWN_AXES if s is None else self.group_of):
            self.activate(name)
        elif name == "FGROUP":
            self.feed_axes = word.arguments
        elif name == "DO" and word.arguments in [(f"$A_OUT[{self.settings.trigger_output}]={k}",) for k in "01"]:
            self.require_alone(word, block)
            self.motions.switch(self.line, word.arguments[0][-1] == "1", at_once=False)
        elif s is None:
            degree = word.value is not None and abs(word.value - MM_A_DEGREE) <= SAME_RADIUS
            if name not in ("TRAFOOF", *(f"FGREF[{axis}]=" for axis in self.angles if degree)):
                self.refuse(word)
            self.said.add(name)
        elif (called := word.written) in (s.transformation, s.transformation_off):
            self.require_alone(word, block)
            self.transformed = called == s.transformation
            self.said = self.said - {s.transformation, "STOPRE"} | {called}
        elif name in ("CTOL=", "OTOL="):
            limit = s.contour_tolerance_mm if name == "CTOL=" else s.orientation_tolerance_deg
            if not 0.0 < float(word.value or 0.0) <= limit:
                self.fail(word, f"{name[:-1]} is not above 0 and at most {limit:g}, the tolerance of the case")
        elif name not in ("PL=", "I", "J", "K") and not name.startswith("PO["):
            self.refuse(word)

    def _outside_motion(self, word: Word, block: dict[str, Word]) -> None:
        """A trace begins and ends, and the control waits for what is before, where the machine stands."""
        self.require_alone(word, block)
        if word.value not in (None, 1.0, 2.0):
            self.fail(word, f"{word.written} is neither the start nor the end of a trace", "write =1 or =2")
        self.said.add(word.name)
        if self.flowing:
            self.fail(word, f"{word.written} while the machine moves on", "let it stop first, write G4 F0.1")

    def _move(self, block: dict[str, Word]) -> None:
        self.take_feed(block)
        pieces = [word for word in block.values() if word.name.startswith("PO[")]
        first = next((word for word in block.values() if word.name in (*self.axes, "I", "J", "K", "PL=")), None)
        first = pieces[0] if pieces else first
        if first is None:
            return
        self.require_said(first)
        if self.of_pose is not None and (pieces or self.active("POLY") or "PL=" in block):
            self.motions.block(self._polynomial(self.of_pose, block, first))
        elif self.active("G2", "G3"):
            self._require_standing(first)
            self.arc(block, first, self.active("G60"))
        else:
            other = next((word for name, word in block.items() if name not in ("G1", "F", *self.axes)), None)
            if other is not None and self.active("COMPCAD"):
                self.fail(other, "the compressor takes nothing but G1, coordinates and F", "write COMPOF before")
            end, duration, feed = self.target(block, first)
            if duration is None:
                self._require_standing(first)
            self.straight(end, duration, feed, self.active("G60"))
        self.flowing = self.active("G64", "G642")

    def _require_standing(self, first: Word) -> None:
        if self.flowing:
            self.fail(first, "the path before runs into this move (G64)", "let the machine stop first, write G4 F0.1")

    def _polynomial(self, settings: Sinumerik, block: dict[str, Word], first: Word) -> TimedBlock:
        """Reads X = a0 + a1 p + .. + a5 p^5 for p from 0 to PL, a1 from the end; p is assumed to be linear in time.

        Refuses what the controller does not accept, or what would not last its time.
        """
        self.require_home(first)
        axes = {f"PO[{axis}]": k for k, axis in enumerate(("X", "Y", "Z", *settings.orientation_axes))}
        pieces = {name: np.array(block[name].arguments, dtype=float) for name in axes if name in block}
        length = float(block["PL="].value or 0.0) if "PL=" in block else 1.0
        degree, most = settings.poly_degree, settings.poly_axes
        if (
            not (self.active("POLY") and self.active("G64") and self.active("G93") and not self.active("COMPCAD"))
            or not (
                set(block) <= {"POLY", "PL=", "F", *axes} and "F" in block and 0 < len(pieces) <= most and length > 0.0
            )
            or any(len(items) > degree or np.abs(items).max() > LARGEST for items in pieces.values())
        ):
            form = f"up to {most} words PO[axis]=(end,a2,..) of degree {degree} at most for {', '.join(axes)}, and F"
            self.fail(first, f"a POLY block under G64 and G93 takes POLY, {form} = 60 / seconds alone", "write it so")
        coefficients = np.zeros((degree + 1, 6))
        coefficients[0], end = self.coordinates, self.coordinates.copy()
        for name, (own_end, *higher) in pieces.items():
            end[axes[name]] = own_end
            coefficients[2 : 2 + len(higher), axes[name]] = [a * length**i for i, a in enumerate(higher, start=2)]
        coefficients[1] = end - coefficients[0] - coefficients[2:].sum(axis=0)
        self.coordinates = end
        return self.line, MINUTE / float(block["F"].value or np.nan), end * self.scale, coefficients * self.scale


def read_sinumerik(content: bytes, file: str, case: Case) -> Reading:
    """Reads a program, see `Dialect.read`."""
    settings = case.need_settings(SinumerikAxes, "a SINUMERIK program")
    lines = program_lines(content, file, LONGEST_LINE, settings.most_blocks)
    return SinumerikInterpreter(file, settings, case).read_program(lines)
