"""A case with other values, validated anew: a plain copy would keep what was computed from the old ones."""

from typing import Any

from cases.schema import Case


def changed(case: Case, **keys: Any) -> Case:
    """The case with values at dotted keys (written with `__`) replaced."""
    data = case.model_dump(exclude_none=True)
    for path, value in keys.items():
        *tables, key = path.split("__")
        table = data
        for name in tables:
            table = table[name]
        assert key in table or key == "keep_out", path
        table[key] = value
    return Case.model_validate(data)
