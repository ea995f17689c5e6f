"""Common style of all pictures: colours that colour-blind readers can distinguish, font sizes, saving."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import Formatter, ScalarFormatter

from supple.errors import ModelError
from supple.storage.atomic_write import replacing

__all__ = ["PUBLISHED", "REFERENCE", "SOLID", "Stroke"]

# Okabe and Ito (2008) without yellow, too light for lines; ordered so that neighbours also differ in grey.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000")
INK = "#222222"
PALE_INK = "#8A8A8A"
SURFACE_COLOUR = "#A9C3D9"
COLOUR_MAP = "viridis"
TEXT_WIDTH = 6.3
"""Width of a picture in inch: the text width of an A4 page."""

_RC: dict[Any, Any] = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.labelsize": 9.0,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "legend.fontsize": 8.0,
    "legend.frameon": False,
    "legend.handlelength": 2.4,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.7,
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "xtick.major.width": 0.7,
    "ytick.major.width": 0.7,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#DDDDDD",
    "grid.linewidth": 0.5,
    "lines.linewidth": 1.4,
    "axes.unicode_minus": True,
    "axes.formatter.useoffset": False,
    "axes.formatter.limits": (-3, 4),
    "axes.formatter.use_mathtext": True,
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    "figure.dpi": 200,
    "savefig.dpi": "figure",
    "svg.fonttype": "none",
    "svg.hashsalt": "supple",
    "path.simplify_threshold": 0.3,
}


@dataclass(frozen=True)
class Stroke:
    """Style of a curve; with colour None, the next colour of the palette."""

    colour: str | None = None
    dashes: tuple[float, ...] = ()
    width: float = 1.4
    marker: str = ""


SOLID = Stroke()
"""A computed result."""
REFERENCE = Stroke(colour="#000000", dashes=(4.0, 2.0), width=1.1)
"""A reference for computed results: a fuller model, another method."""
PUBLISHED = Stroke(colour="#000000", width=0.0, marker="o")
"""Published points."""


@contextmanager
def textbook_style() -> Iterator[None]:
    """Use the library's style within this block, then restore matplotlib's settings."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(_RC)
        yield


def new_figure(height: float, width: float = TEXT_WIDTH) -> Figure:
    """A figure of a size in inches, without a window and without matplotlib's global state."""
    return Figure(figsize=(width, height), layout="constrained")


def as_written(name: str) -> str:
    """The name with dollar signs escaped, so that matplotlib draws them and begins no formula."""
    return name.replace("$", r"\$")


def draw_curve(axes: Axes, x, y, stroke: Stroke, rank: int, label: str) -> None:
    """One curve, coloured by its rank unless the stroke has a colour."""
    (line,) = axes.plot(
        x,
        y,
        color=stroke.colour or COLOURS[rank % len(COLOURS)],
        linewidth=stroke.width,
        marker=stroke.marker,
        markersize=4.0,
        markerfacecolor="white",
        label=label,
    )
    if stroke.dashes:
        line.set_dashes(stroke.dashes)


def legend_above(axes: Axes) -> None:
    """A legend above the axes, where it covers no curve, with as many columns as fit."""
    labels = axes.get_legend_handles_labels()[1] or [""]
    longest = max(map(len, labels))
    # Inches: the line with its gaps, and a character of the legend's font.
    column_width = 0.5 + 0.075 * longest
    fitting = max(1, int((TEXT_WIDTH - 0.8) / column_width))
    # The fewest columns that need no further row fill the last row best.
    rows = -(-len(labels) // min(fitting, len(labels)))
    axes.legend(
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        ncols=-(-len(labels) // rows),
        borderaxespad=0.2,
        columnspacing=1.6,
    )


class _Numbers(Formatter):
    """Numbers at ticks as plain text, which is drawn in a tenth of the time of matplotlib's formulas.

    The text looks like the formulas. The power of ten at the end of the axis remains a formula.
    """

    def __init__(self, formulas: ScalarFormatter) -> None:
        self._formulas = formulas

    def __call__(self, x: float, pos: int | None = None) -> str:
        return self._formulas(x, pos).removeprefix(r"$\mathdefault{").removesuffix("}$")

    def set_axis(self, axis: Any) -> None:
        """Set the axis of the numbers."""
        super().set_axis(axis)
        self._formulas.set_axis(axis)

    def set_locs(self, locs: list[float]) -> None:
        """Set the positions of all ticks, which determine the number of digits."""
        self._formulas.set_locs(locs)

    def get_offset(self) -> str:
        """The power of ten at the end of the axis."""
        return self._formulas.get_offset()


_TYPES = {".png": "image/png", ".gif": "image/gif", ".svg": "image/svg+xml", ".jpg": "image/jpeg"}
# Before Python 3.12 the class of a path depends on the system.
_Path = Path if TYPE_CHECKING else type(Path())


class Picture(_Path):
    """Path of a picture; a notebook shows the picture, everything else uses the path."""

    def _repr_html_(self) -> str | None:
        kind = _TYPES.get(self.suffix.lower())
        if kind is None or not self.is_file():
            return None
        content = b64encode(self.read_bytes()).decode("ascii")
        return f'<img src="data:{kind};base64,{content}" alt="{escape(self.name)}" style="max-width: 100%">'


def save_figure(figure: Figure, path: Path | str) -> Picture:
    """Save a figure atomically in the format of the path's suffix (png, pdf, svg, ...), and return the path.

    Raises
    ------
    ModelError          no suffix, or a format that matplotlib cannot write
    ResultFileError     the file cannot be written
    """
    path = Picture(path)
    picture_format = path.suffix.lstrip(".").lower()
    known = figure.canvas.get_supported_filetypes()
    if picture_format not in known:
        raise ModelError(
            f"cannot draw {path}: no picture format '{path.suffix}'; use one of {', '.join(sorted(known))}"
        )
    # Without the date, the same data gives the same file.
    undated = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(picture_format)
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            formatter = axis.get_major_formatter()
            if type(formatter) is ScalarFormatter:
                axis.set_major_formatter(_Numbers(formatter))
    # Laid out once here: matplotlib would lay the figure out for a trial drawing and again for the picture.
    if layout := figure.get_layout_engine():
        layout.execute(figure)
        figure.set_layout_engine("none")
    with replacing(path) as temporary:
        if picture_format == "png":
            # `savefig` would draw everything twice, for a trial first.
            FigureCanvasAgg(figure).print_png(temporary)
        else:
            figure.savefig(temporary, format=picture_format, metadata=undated)
    return path
