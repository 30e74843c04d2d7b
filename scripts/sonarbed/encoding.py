"""Text for terminals and files whose encoding does not know all our characters."""

from __future__ import annotations

import codecs
from types import MappingProxyType
from typing import TextIO

__all__ = ["plain_where_needed"]

_PLAIN = MappingProxyType(
    {"²": "2", "±": "+-", "×": "x", "°": " deg", "·": "-", "–": "-", "—": "-", "…": "...", "µ": "u"}
)
_HANDLER = "sonarbed.plain"


def plain_where_needed(*streams: TextIO) -> None:
    """Let streams write what their encoding does not know in plain letters: m2 for m²."""
    codecs.register_error(_HANDLER, _plainly)
    for stream in streams:
        reconfigure = getattr(stream, "reconfigure", None)
        # A stream of another make, as a notebook's, has its own way.
        if reconfigure is not None and getattr(stream, "errors", None) != _HANDLER:
            reconfigure(errors=_HANDLER)


def _plainly(error: UnicodeError) -> tuple[str | bytes, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    unknown = error.object[error.start : error.end]
    return "".join(_PLAIN.get(letter, "?") for letter in unknown), error.end
