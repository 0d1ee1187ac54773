"""What pages need is there when a search ends."""

import sys
from threading import enumerate as threads

from hexcite.cli.plan import with_page_at_hand
from planner.plans.progress import Standing


def test_modules_of_pages_load_while_the_best_starts_are_refined():
    lines: list[str] = []
    before = set(threads())
    remark = with_page_at_hand(lambda standing: lines.append(standing.line))
    remark(Standing("searching"))
    assert set(threads()) == before
    remark(Standing("refining", refining=True))
    for thread in set(threads()) - before:
        thread.join()  # an exception in it is a warning, and so an error
    assert lines == ["searching", "refining"]
    assert {"hexcite.reports.plan", "hexcite.reports.drawing.still"} <= sys.modules.keys()
