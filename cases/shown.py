"""How values are shown in notebooks."""

from html import escape


def as_html(text: str) -> str:
    """Text as it stands, for `_repr_html_`."""
    return f"<pre>{escape(text)}</pre>"
