"""Which words of SINUMERIK an excitation may use, what excludes what, and what to write instead of the others."""

LONGEST_LINE = 512

# Two words of one modal group in a block are an error to the controller.
GROUPS: tuple[tuple[str, ...], ...] = (
    ("G0", "G1", "G2", "G3", "POLY", "ASPLINE", "BSPLINE", "CSPLINE"),
    ("G17", "G18", "G19"),
    ("G90", "G91"),
    ("G70", "G71", "G700", "G710"),
    ("G93", "G94", "G95"),
    ("G60", "G64", "G641", "G642", "G643", "G644", "G645"),
    ("G40", "G41", "G42"),
    ("G500", "G54", "G55", "G56", "G57"),
    ("COMPOF", "COMPON", "COMPCURV", "COMPCAD", "COMPSURF"),
    ("BRISK", "SOFT", "DRIVE"),
    ("FFWON", "FFWOF"),
    ("DYNNORM", "DYNPOS", "DYNROUGH", "DYNSEMIFIN", "DYNFINISH", "DYNPREC"),
    ("ORIWKS", "ORIMKS"),
    ("ORIEULER", "ORIRPY", "ORIRPY2", "ORIVIRT1", "ORIVIRT2"),
    ("ORIAXES", "ORIVECT", "ORIPLANE"),
    ("PTP", "PTPG0", "CP"),
    ("G4",),
    ("M2", "M17", "M30"),
)

# Words that a proven program may hold; those that change nothing it relies on need no more than this.
NEUTRAL = {"G40", "FFWON", "FFWOF", "DYNNORM", "DYNPOS", "MSG", "N"}
MODAL = {
    *("G0", "G1", "G2", "G3", "POLY", "G17", "G18", "G19", "G90", "G710", "G93", "G94", "G60", "G64", "G642"),
    *("G500", "COMPOF", "COMPCAD", "SOFT", "ORIWKS", "ORIRPY", "ORIAXES", "PTP", "CP"),
}

REMEDY = {
    "G20": "no inches here but unknown to SINUMERIK; write G710 for millimetres",
    "G21": "unknown to SINUMERIK; write G710 for millimetres",
    "G70": "inches; write G710",
    "G71": "millimetres for the geometry alone, not for feeds; write G710",
    "G700": "inches; write G710",
    "G61": "not used here; write G60 for exact stop",
    "G9": "an exact stop in this block alone; write G60",
    "G80": "no cancel of cycles here; remove it",
    "G91": "incremental coordinates; write G90",
    "G95": "feed per revolution; write G94 or G93",
    "G54": "a frame that the proof does not know; write G500",
    "BRISK": "without jerk limit; write SOFT",
    "DRIVE": "without jerk limit; write SOFT",
    "ORIEULER": "another order of rotations; write ORIRPY",
    "ORIRPY2": "another order of rotations; write ORIRPY",
    "ORIMKS": "relative to the machine, not the workpiece; write ORIWKS",
    "ORIVECT": "a turn on a great circle, not along the angles; write ORIAXES",
    "ORIPLANE": "a turn on a great circle, not along the angles; write ORIAXES",
    "PTPG0": "straight in the machine's axes in rapid moves alone; write PTP",
    "STAT=": "a choice among assemblies, of which a hexapod has one; remove it",
    "TU=": "a choice among turns, of which struts have none; remove it",
    "RTLIOF": "ignored while a transformation is active; remove it",
    "ASPLINE": "a spline whose time law nobody states; write POLY",
    "BSPLINE": "a spline whose time law nobody states; write POLY",
    "CSPLINE": "a spline whose time law nobody states; write POLY",
    "STOPRE": "a stop of the look-ahead; remove it",
    "M17": "the end of a subprogram; write M30",
    "M62": "no output here; write DO $A_OUT[n]=1",
    "M63": "no output here; write DO $A_OUT[n]=0",
    "M64": "no output here; write DO $A_OUT[n]=1",
    "M65": "no output here; write DO $A_OUT[n]=0",
    "P": "no word of an excitation; G4 takes seconds as F",
}
