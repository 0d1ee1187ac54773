"""Strict JSON: one object, no NaN, nothing around it."""

import json
from typing import Any, NoReturn


def _no(name: str) -> NoReturn:
    raise AssertionError(f"{name} is not JSON")


def one_json_object(text: str) -> dict[str, Any]:
    """The object that `text` is."""
    value = json.loads(text, parse_constant=_no)
    assert isinstance(value, dict)
    return value
