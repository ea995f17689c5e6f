"""Display of an object by `print` and in a notebook: a title and a few rows of name and value."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

Row = tuple[str, str]

N_LINES = 10
"""Largest number of lines of a printed object, with its title."""
N_LISTED = 6
"""Largest number of names in one row."""
WIDTH = 140
"""Largest number of characters in a line."""


@dataclass(frozen=True)
class Summary:
    """A title, and rows of name and value."""

    title: str
    rows: Sequence[Row] = ()

    @property
    def shown(self) -> tuple[Row, ...]:
        """The rows that fit in `N_LINES`; the last one states how many are left out."""
        most = N_LINES - 1
        if len(self.rows) <= most:
            return tuple(self.rows)
        return (*self.rows[: most - 1], ("...", f"{len(self.rows) - most + 1} rows more"))

    def __str__(self) -> str:
        wide = max((len(name) for name, _ in self.shown), default=0)
        lines = (self.title, *(f"  {name:<{wide}}  {value}" for name, value in self.shown))
        return "\n".join(line if len(line) <= WIDTH else line[: WIDTH - 3] + "..." for line in lines)

    def _repr_html_(self) -> str:
        rows = "".join(
            f'<tr><th style="text-align:left">{escape(name)}</th><td style="text-align:left">'
            f"{escape(value)}</td></tr>"
            for name, value in self.shown
        )
        title = f'<caption style="text-align:left"><b>{escape(self.title)}</b></caption>'
        return f"<table>{title}{rows}</table>"


class Summarized:
    """Base of objects with a `summary`: `print` shows up to ten lines, a notebook a table, `repr` the title.

    A dataclass with this base needs `repr=False`.
    """

    def summary(self) -> Summary:
        """Title and rows."""
        raise NotImplementedError

    def __repr__(self) -> str:
        return f"<{self.summary().title}>"

    def __str__(self) -> str:
        return str(self.summary())

    def _repr_html_(self) -> str:
        return self.summary()._repr_html_()


def listed(names: Iterable[str]) -> str:
    """Names separated by commas; if more than `N_LISTED`, the first ones and the count."""
    every = list(names)
    more = f", ... ({len(every)} in all)" if len(every) > N_LISTED else ""
    return (", ".join(every[:N_LISTED]) or "none") + more


def place_text(position: Sequence[float] | np.ndarray, size: float = 0.0) -> str:
    """Coordinates in parentheses; values below 1e-12 of the largest, or of `size`, are shown as 0."""
    values = np.asarray(position, dtype=np.float64)
    values = np.where(abs(values) > 1e-12 * abs(values).max(initial=size), values, 0.0)
    return "(" + ", ".join(f"{value:g}" for value in values) + ")"
