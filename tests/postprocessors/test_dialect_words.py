"""Fragments that vendors print are words of their language; what means something else in another one is refused.

The fragments are quoted from manuals: SINUMERIK ONE and 828D programming, 810D PGA, TF5200 programming, commissioning.
"""

import pytest

from cases.base.errors import ProgramError
from postprocessors.dialects.sinumerik.read import SinumerikInterpreter
from postprocessors.dialects.twincat.read import TwinCatInterpreter
from postprocessors.program import dialect
from tests.helpers import one_line
from tests.postprocessors.other_dialects import BOTH, CASE, SINUMERIK, TWINCAT, Typed
from tests.postprocessors.programs import typed as typed_linuxcnc

SINUMERIK_FRAGMENTS = {
    "N10 G00 X30 Y6 Z40": ["G0", "X", "Y", "Z"],
    "N20 G1 F10000 G642 ; Activation: Rounding function G642": ["G1", "F", "G642"],
    "N30 SOFT": ["SOFT"],
    "N40 COMPCAD": ["COMPCAD"],
    "N50 FIFOCTRL": ["FIFOCTRL"],
    "N24050 Z32.499": ["Z"],
    "N24051 X41.365 Z32.500": ["X", "Z"],
    "COMPOF": ["COMPOF"],
    "N10 COMPON": ["COMPON"],
    "N11 G1 X0.37 Y2.9 F600": ["G1", "X", "Y", "F"],
    "N12 X16.87 Y-.698": ["X", "Y"],
    "N1037 COMPOF": ["COMPOF"],
    "N10 G0 X0 Y-30 Z60 A-30 F10000": ["G0", "X", "Y", "Z", "A", "F"],
    "N20 TRAORI(1)": ["TRAORI"],
    "N30 X1000 Y0 Z400 A0": ["X", "Y", "Z", "A"],
    "N50 X1200 Z400 CP": ["X", "Z", "CP"],
    "N60 X1000 Z500 A20": ["X", "Z", "A"],
    "N70 M30": ["M30"],
    "N30 RTLIOF": ["RTLIOF"],
    "N70 RTLION": ["RTLION"],
    "N11 POLY PO[X]=(1,2.5,0.7) PO[Y]=(0.3,1,3.2) PL=1.5": ["POLY", "PO[X]", "PO[Y]", "PL="],
    "N12 PO[X]=(0,2.5,1.7) PO[Y]=(2.3,1.7) PL=3": ["PO[X]", "PO[Y]", "PL="],
    "N110 FGROUP(X,A)": ["FGROUP"],
    "N120 G91 G1 G710 F100 ; Feedrate = 100mm/min or 100 degrees/min": ["G91", "G1", "G710", "F"],
    "N130 DO $R1=$AC_TIME": ["DO"],
    "DO $A_OUTA[1]=$AA_IN[X]": ["DO"],
    "G93 G01 X100 F2": ["G93", "G1", "X", "F"],
    'MSG("text; with a semicolon")': ["MSG"],
    "CIP X10 I1=5 J1=6": ["CIP", "X", "I1=", "J1="],
}
TWINCAT_FRAGMENTS = {
    "N05 #KIN ID[5]            ; a comment": ["#KIN ID"],
    "N10 #TRAFO ON": ["#TRAFO ON"],
    "N20 X100 Y100 A0": ["X", "Y", "A"],
    "N30 Z10 C0": ["Z", "C"],
    "N40 #TRAFO OFF": ["#TRAFO OFF"],
    "#TRAFO [87]": ["#TRAFO"],
    "#TRAFO [OFF]": ["#TRAFO"],
    "N10  #SPLINE TYPE BSPLINE ; (de)": ["#SPLINE TYPE BSPLINE"],
    "N20  G01 X0 Y50 Z0 F10000": ["G1", "X", "Y", "Z", "F"],
    "N30  #SPLINE ON": ["#SPLINE ON"],
    "N40   X3     Y25": ["X", "Y"],
    "N160 #SPLINE OFF": ["#SPLINE OFF"],
    "N05 #CONTOUR MODE [DEV, PATH_DEV=5]": ["#CONTOUR MODE"],
    "N10 G261": ["G261"],
    "N20 G01 G90 X100 F10000": ["G1", "G90", "X", "F"],
    "N2000 G260": ["G260"],
    "N10 G04 X4.5": ["G4", "X"],
    "N20 G04 3.0": ["G4", ""],
    "N20 G1 G60 X10  ; Exact stop for this block end": ["G1", "G60", "X"],
    'N10 #MSG ["WERT=%D", 10]': ["#MSG"],
    '#MSG SYN ["Text_4"]': ["#MSG SYN"],
    "N20 G194 F90 ; Weighting 90% to max. axis feedrate": ["G194", "F"],
    "N120 G93 F20 ; Machining time 20 s": ["G93", "F"],
    "N70 #HSC ON [BSPLINE PATH_DEV=0.02 TRACK_DEV=0.05]": ["#HSC ON"],
    "N20 #SLOPE [TYPE=TRAPEZ]": ["#SLOPE"],
    "N40 #PTP ON": ["#PTP ON"],
    "G130 X70": ["G130", "X"],
}


SINUMERIK_SKELETON = """%_N_HEXA_ID_MPF
;$PATH=/_N_MPF_DIR
N10 G17 G90 G94 G710 G40 G500
N20 TRAORI
N30 ORIWKS ORIRPY
N40 SOFT FFWON DYNNORM
N50 FGROUP(X,Y,Z)
N60 G0 X0 Y0 Z0 A2=0 B2=0 C2=0
N70 G1 G642 F3000
N80 COMPCAD CTOL=0.02 OTOL=0.05
N90 X1.0 Y0.5 Z0.2 A2=0.1 B2=-0.2 C2=0.3
N100 COMPOF
N110 G4 F0.5
N120 TRAFOOF
N130 M30"""
TWINCAT_SKELETON = """%HEXAPOD_ID
N10 G71 G90 G17 G94 G162
N20 #SLOPE [TYPE=TRAPEZ]
N30 #KIN ID[5]
N40 #TRAFO ON
N50 #FGROUP [X,Y,Z]
N60 G01 X0 Y0 Z0 A0 B0 C0 F3000
N70 #HSC ON [BSPLINE PATH_DEV=0.02 TRACK_DEV=0.05]
N80 X1.0 Y0.5 Z0.2 A0.1 B-0.2 C0.3
N90 X2.0 Y1.0 Z0.4 A0.2 B-0.4 C0.6
N100 #HSC OFF
N110 G04 0.5
N120 #TRAFO OFF
N130 M30"""


def test_every_line_of_the_skeletons_is_made_of_words():
    """Whole, neither is read: what their blocks without exact stop or kind of angles mean is not known."""
    for text, words, typed in (
        (SINUMERIK_SKELETON, SinumerikInterpreter.words, SINUMERIK),
        (TWINCAT_SKELETON, TwinCatInterpreter.words, TWINCAT),
    ):
        for number, line in enumerate(text.split("\n"), start=1):
            assert bool(words(line, number, "p")) != line.startswith(";")
        with pytest.raises(ProgramError, match=r"G60|ORIAXES|D0|G53"):
            typed.read(text)


@pytest.mark.parametrize("fragment", SINUMERIK_FRAGMENTS)
def test_fragments_of_siemens_are_words(fragment: str):
    assert [w.name for w in SinumerikInterpreter.words(fragment, 2, "p")] == SINUMERIK_FRAGMENTS[fragment]


@pytest.mark.parametrize("fragment", TWINCAT_FRAGMENTS)
def test_fragments_of_beckhoff_are_words(fragment: str):
    assert [w.name for w in TwinCatInterpreter.words(fragment, 2, "p")] == TWINCAT_FRAGMENTS[fragment]


def test_numbers_lists_and_actions_are_kept():
    piece = SinumerikInterpreter.words("N11 POLY PO[X]=(1,2.5,-.7) PL=1.5", 2, "p")
    assert piece[1].arguments == ("1", "2.5", "-.7")
    assert piece[2].value == 1.5
    assert SinumerikInterpreter.words("do $a_out[25] = 1", 2, "p")[0].arguments == ("$A_OUT[25]=1",)
    assert TwinCatInterpreter.words("#HSC ON [BSPLINE PATH_DEV=0.02 TRACK_DEV=0.05]", 2, "p")[0].arguments == (
        "BSPLINE",
        "PATH_DEV=0.02",
        "TRACK_DEV=0.05",
    )


# What means something else, or nothing, to this controller: dialect -> line -> what the refusal says.
TRAPS: list[tuple[Typed, str, str]] = [
    (SINUMERIK, "G21", "G21 is not read here"),
    (SINUMERIK, "G20", "G20 is not read here"),
    (SINUMERIK, "G71", "G71 is not read here"),
    (SINUMERIK, "G80", "G80 is not read here"),
    (SINUMERIK, "G61", "G61 is not read here"),
    (SINUMERIK, "G64 P0.02 Q0", r"P0\.02 is not read here"),
    (SINUMERIK, "(a comment of LinuxCNC)", r"cannot read '\(a comment o'"),
    (SINUMERIK, "G4 P0.3", r"P0\.3 is not read here"),
    (SINUMERIK, "G04 X0.3", "G4 stands in a block of its own"),
    (SINUMERIK, "G4 0.3", "cannot read '0.3'"),
    (SINUMERIK, "M64 P0", "M64 is not read here"),
    (SINUMERIK, "G1 X1 A1 F100", "A1 is not read here"),
    (SINUMERIK, "G1 X1 A210 F100", "A210 is not read here"),
    (SINUMERIK, "G1 X1e-3 F100", "E-3 is not read here"),
    (SINUMERIK, "G1 X1,5 F100", "cannot read ',5"),
    (SINUMERIK, "ORIEULER\nG1 X1 F100", "ORIEULER is not read here"),
    (SINUMERIK, "RTLIOF", "RTLIOF is not read here"),
    (SINUMERIK, "STAT='B10'", "cannot read"),
    (SINUMERIK, "IDS=1 EVERY $A_IN[1]==1 DO $A_OUT[1]=1", "cannot read"),
    (SINUMERIK, "ids=39 whenever($r829>=120000) do $a_out[1]=1", "cannot read"),
    (SINUMERIK, "#HSC ON", "cannot read '#HSC ON'"),
    (SINUMERIK, "G162", "G162 is not read here"),
    (TWINCAT, "G1 G60 X1 F100 (a comment)", r"cannot read '\(a comment"),
    (TWINCAT, "G21", "G21 is not read here"),
    (TWINCAT, "G70", "G70 is not read here"),
    (TWINCAT, "G80", "G80 is not read here"),
    (TWINCAT, "G61", "G61 is not read here"),
    (TWINCAT, "G60", r"without a motion in its block \(error 20003\)"),
    (TWINCAT, "G01 G9 X1 F100", "G9 is not read here"),
    (TWINCAT, "G64 P0.02 Q0", "G64 is not read here"),
    (TWINCAT, "G64", "G64 is not read here"),
    (TWINCAT, "G4 P0.3", "G04 0.3|P is not a word"),
    (TWINCAT, "G4 F0.3", "G4 stands in a block of its own"),
    (TWINCAT, "M64 P0", "M64 is not read here"),
    (TWINCAT, "G1 G60 X1 A2=1 F100", "cannot read '=1 F100'"),
    (TWINCAT, "G1 G60 X1e-3 F100", "E-3 is not read here"),
    (TWINCAT, "G1 G60 X1,5 F100", "cannot read ',5"),
    (TWINCAT, "G01 G60 X[1+2] F100", "cannot read"),
    (TWINCAT, "G40 G49", "G49 is not read here"),
    (TWINCAT, "G91.1", r"G91\.1 is not read here"),
    (TWINCAT, "TRAORI", "cannot read 'TRAORI'"),
    (TWINCAT, "G710", "G710 is not read here"),
    (TWINCAT, "MSG(1)", "cannot read 'MSG"),
    (TWINCAT, "DO $A_OUT[1]=1", "cannot read 'DO"),
]
LINUXCNC_TRAPS = {
    "G71": "G71",
    "G710": "G710|G-code",
    "G60": "G60",
    "G1 A2=1 F100": "cannot read",
    "X=10": "cannot read",
    "#HSC ON": "cannot read '#HSC ON'",
    "G4 F0.3": "G4 needs a duration",
    "G4 X0.3": "G4 needs a duration",
    "G04 0.3": "cannot read|G4 needs",
    "(an (inner) comment)": "cannot read",
    "TRAORI": "cannot read",
    "FGROUP(X,Y,Z)": "cannot read|not a word",
    "DO $A_OUT[1]=1": "cannot read",
    "M100": "M100 is not read here",
}


@pytest.mark.parametrize(("typed", "line", "words"), TRAPS, ids=lambda v: getattr(v, "name", v))
def test_what_another_controller_means_by_it_is_refused(typed: Typed, line: str, words: str):
    with pytest.raises(ProgramError, match=words) as caught:
        typed.read(typed.text(line))
    assert one_line(caught.value).startswith(f"p, line {typed.first}")


@pytest.mark.parametrize("line", LINUXCNC_TRAPS)
def test_words_of_the_others_are_refused_by_linuxcnc(line: str):
    with pytest.raises(ProgramError, match=LINUXCNC_TRAPS[line]):
        dialect("linuxcnc").read(typed_linuxcnc(line).encode(), "p.ngc", CASE)


@pytest.mark.parametrize("typed", BOTH, ids=lambda t: t.name)
def test_the_frame_around_the_refused_lines_is_itself_proven(typed: Typed):
    assert typed.proof(typed.text(f"G1 G60 X1 {typed.angle}1 F3000")).ok


@pytest.mark.parametrize("writer", ["linuxcnc", *BOTH], ids=lambda t: getattr(t, "name", t))
@pytest.mark.parametrize("reader", ["linuxcnc", "sinumerik", "twincat"])
def test_a_whole_program_is_read_in_its_own_language_alone(writer: Typed | str, reader: str):
    name = writer if isinstance(writer, str) else writer.name
    text = typed_linuxcnc("G1 X1 A1 F3000") if isinstance(writer, str) else writer.text(f"G1 G60 X1 {writer.angle}1 F9")
    language = dialect(reader)
    if name == reader:
        assert language.read(text.encode(), "p", CASE).stretches
    else:
        with pytest.raises(ProgramError):
            language.read(text.encode(), "p", CASE)
