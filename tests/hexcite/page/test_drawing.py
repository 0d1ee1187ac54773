"""The drawing of a machine beside its values."""

import re
from itertools import combinations

import pytest

import hexcite as hx
from hexcite.page.drawing import LETTER, LINE, views

TEXT = re.compile(r'<text x="([-0-9.]+)" y="([-0-9.]+)">([^<]*)</text>')


@pytest.mark.parametrize("view", ["above", "side"])
def test_no_name_of_a_joint_or_sensor_covers_another(view: str):
    texts = [(float(x), float(y), text) for x, y, text in TEXT.findall(getattr(views(hx.load_case("hexapod")), view))]
    assert len(texts) > 6
    for (x, y, text), (u, v, other) in combinations(texts, 2):
        clear = x + LETTER * len(text) <= u + 0.2 or u + LETTER * len(other) <= x + 0.2 or abs(y - v) >= LINE - 0.2
        assert clear, f"{text!r} and {other!r}"
