"""Options of commands for what values advise.

Texts of values name no option: the library and the page show them too. The command line names the options behind what
it prints, by the codes of the sentences.
"""

from collections.abc import Iterator, Mapping
from typing import Any

OPTIONS: Mapping[str, str] = {
    "not_converged": "--starts",
    "drawn_back": "--seed",
    "less_moves": "--moves",
    "free_period": "--free-period",
    "moves_instead": "--family ptp",
    "timed_moves": "--family ptp",
    "needless_harmonics": "--order {order}",
    "whole_periods": "--duration {more}",
    "order_1": "--order 3",
    "tolerances_not_counted": "--prior",
    "no_plan_beside": "--plan",
    "another_motion": "--plan",
    "recorded_with_another": "--case",
    "joints_or_drives": "--case",
    "name_the_robot": "--case",
}
"""Code of a sentence -> the option that it is about, with values of the sentence in braces."""


def advice(answer: object) -> tuple[str, ...]:
    """A line with the options that sentences in a JSON answer are about, each once; empty where there are none.

    >>> advice({"notes_phrases": [{"code": "needless_harmonics", "values": {"order": "2", "share": "99.8"}}]})
    ('options for that: --order 2',)
    """
    options = dict.fromkeys(_options(answer))
    return (f"options for that: {', '.join(options)}",) if options else ()


def _options(entry: Any) -> Iterator[str]:
    if isinstance(entry, Mapping):
        code, values = entry.get("code"), entry.get("values")
        if isinstance(code, str) and isinstance(values, Mapping) and code in OPTIONS:
            yield OPTIONS[code].format(**values)
        entry = list(entry.values())
    for inner in entry if isinstance(entry, list | tuple) else ():
        yield from _options(inner)
