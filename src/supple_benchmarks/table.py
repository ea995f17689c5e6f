"""A table of a report."""

from __future__ import annotations

__all__ = ["Table"]

Table = tuple[str, list[str], list[list[str]]]
"""Title, column heads, rows."""
