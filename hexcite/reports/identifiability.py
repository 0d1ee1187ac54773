"""Figures and tables of which parameters can be told apart (Figure 3)."""

from collections.abc import Sequence

import numpy as np

from cases.base.phrases import Phrase, phrase
from hexcite.reports.drawing.chart import Axis, Chart, Heat
from hexcite.reports.page import Block, note, table
from identification.results.identifiability import Identifiability

HEIGHT = 460  # of a square of parameters [pixels]


def identifiability_charts(value: Identifiability) -> tuple[Chart, ...]:
    """Magnitudes of the correlations of the regressor's columns, and of R of the scaled regressor."""
    across, down = Axis(names=value.names, tilt=90.0), Axis(names=value.names, downwards=True)
    return (
        Chart(
            "columns",
            phrase(
                "columns_alike",
                "Magnitude of the Pearson correlation of the columns of the regressor, model {model}: near 1 two "
                "parameters make nearly the same forces.",
                model=value.model,
            ),
            (Heat(np.abs(value.correlation)),),
            across,
            down,
            height=HEIGHT,
            half=True,
        ),
        Chart(
            "qr",
            phrase(
                "r_of_regressor",
                "Magnitude of R of the QR decomposition of the scaled regressor. A diagonal element of numerical zero "
                "({zero}): the parameters before it make the same forces. A large value above the diagonal: "
                "the parameter of the column depends on that of the row.",
                zero=f"{value.zero:.1g}",
            ),
            (Heat(np.minimum(np.abs(value.r), 1.0)),),
            across,
            down,
            height=HEIGHT,
            half=True,
        ),
    )


def identifiability_blocks(models: Sequence[Identifiability], number: int) -> tuple[Block, ...]:
    """What each model could tell apart, and the figures of the one that is used."""
    rows = [
        (
            phrase("this_model", "{model} (this one)", model=m.model) if m.model == number else str(m.model),
            "yes" if m.determined else "NO",
            phrase("rank_of", "{rank} of {count}", rank=m.rank, count=len(m.names)),
            f"{m.condition:.3g}" if m.determined else "-",
        )
        for m in models
    ]
    sentences: dict[Phrase, list[str]] = {}
    for m in models:
        for sentence in m.sentences:
            sentences.setdefault(sentence, []).append(str(m.model))
    (used,) = (m for m in models if m.model == number)
    return (
        table(("model", "works", "rank", "condition"), rows, left=2),
        *(
            note(
                phrase("of_models", "Models {numbers}: {sentence}.", numbers=", ".join(numbers), sentence=sentence)
                if len(numbers) > 1
                else phrase("of_model", "Model {number}: {sentence}.", number=numbers[0], sentence=sentence)
            )
            for sentence, numbers in sentences.items()
        ),
        note(
            "By the motion alone, without forces, all channels weighed alike. Models 0 to 9: Table 2; 10: model 3 with "
            "inertia. The condition is that of the scaled regressor (26)."
        ),
        *identifiability_charts(used),
    )
