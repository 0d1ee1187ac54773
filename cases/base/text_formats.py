"""Plain values as JSON and TOML write them."""

import json
import re
from collections.abc import Mapping
from typing import Any

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")  # of TOML, which needs no quotes


def toml_text(values: Mapping[str, Any], table: str = "") -> str:
    """TOML of plain values: tables as sections, those in lists inline."""
    tables = {key: value for key, value in values.items() if isinstance(value, dict)}
    lines = [f"{_toml_key(key)} = {toml_value(value)}" for key, value in values.items() if key not in tables]
    lines = [*([f"[{table}]"] if table and (lines or not tables) else []), *lines]
    for key, value in tables.items():
        lines += ["", toml_text(value, f"{table}.{_toml_key(key)}" if table else _toml_key(key))]
    return "\n".join(lines)


def toml_value(value: Any) -> str:
    """A value as TOML writes it in one line."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{_toml_key(key)} = {toml_value(inner)}" for key, inner in value.items()) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(toml_value, value)) + "]"
    text = json.dumps(value, ensure_ascii=False)
    return text if text.isprintable() else "".join(c if c.isprintable() else _of_toml(c) for c in text)


def ascii_text(text: str) -> str:
    """A text in double quotes and plain ASCII, as TOML and YAML write it."""
    return "".join(c if c.isascii() else _of_toml(c) for c in json.dumps(text, ensure_ascii=False))


def _of_toml(character: str) -> str:
    """A character that no paper shows, as TOML and YAML write it."""
    code = ord(character)
    return f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"


def _toml_key(key: str) -> str:
    return key if _BARE_KEY.fullmatch(key) else toml_value(key)


def json_text(value: Any) -> str:
    """JSON with two-space indent; NaN and infinity are refused, since they are not JSON."""
    return json.dumps(value, indent=2, allow_nan=False) + "\n"
