"""Which words of TwinCAT CNC (ISG) an excitation may use, what excludes what, and what to write instead."""

LONGEST_LINE = 4096  # beyond it: error 20301
MOST_MESSAGES = 10  # unread ones stop the controller

# Two words of one modal group in a block are an error to the controller.
GROUPS: tuple[tuple[str, ...], ...] = (
    ("G0", "G1", "G2", "G3"),
    ("G17", "G18", "G19"),
    ("G90", "G91"),
    ("G70", "G71"),
    ("G93", "G94", "G95", "G194"),
    ("G161", "G162"),
    ("G260", "G261"),
    ("G359", "G360"),
    ("G4",),
    ("M2", "M30"),
)
MODAL = {
    *("G0", "G1", "G2", "G3", "G17", "G18", "G19", "G90", "G71", "G93", "G94", "G162", "G260", "G261", "G359", "G360")
}

REMEDY = {
    "G20": "mirroring here, not inches; write G71 for millimetres",
    "G21": "mirroring here, not millimetres; write G71",
    "G22": "mirroring; remove it",
    "G23": "mirroring; remove it",
    "G61": "polynomial contouring here, not exact stop; write G60",
    "G64": "unknown here; write #SPLINE ON, #HSC ON or #CONTOUR MODE and G261",
    "G9": "a deceleration here, not an exact stop; write G60",
    "G70": "inches; write G71",
    "G91": "incremental coordinates; write G90",
    "G95": "feed per revolution; write G94 or G93",
    "G194": "a share of the largest feed; write G94 or G93",
    "G161": "absolute arc centres; write G162",
    "G150": "written #SPLINE OFF here",
    "G151": "written #SPLINE ON here",
    "G40": "the default; remove it",
    "G49": "unknown here; remove it",
    "G54": "a zero offset that the proof does not know; remove it",
    "G53": "the default; remove it",
    "M17": "the end of a subprogram; write M30",
    "M29": "the end of a subprogram; write M30",
    "#SPLINE TYPE BSPLINE": "a curve near its points, not through them; write #SPLINE TYPE AKIMA",
    "#COMMENT BEGIN": "a comment over several lines; write ; in each",
    **{f"G{n}": "a subroutine call here, not a cycle; remove it" for n in range(80, 90)},
    **{f"M{n}": "no output here; write the trigger's M function" for n in range(62, 66)},
}
