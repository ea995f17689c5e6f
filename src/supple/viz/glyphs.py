"""Glyphs for parts without a mesh. Lines: rigid bodies, springs, ties. Marks: joints, masses, ground."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from numpy.typing import NDArray

from supple.arrays import FloatArray
from supple.body import RigidBody, in_space
from supple.integrate import FloatingMotion, Solution
from supple.machine import GROUND, Joint, System
from supple.quantities import tracked_motion
from supple.results.body_surface import BodySurface
from supple.results.camera import Camera
from supple.viz.style import COLOURS, INK, PALE_INK

__all__ = ["Glyphs", "glyphs_of", "surface_glyphs"]


LEGEND_COLUMNS = 4
"""Columns of the legend of the marks."""


class MarkStyle(NamedTuple):
    """Style of a mark: matplotlib's marker, its size in points squared, its colours, and its name."""

    name: str
    marker: str
    size: float = 34.0
    face: str = "white"
    edge: str = INK
    hatch: str = ""


GROUND_STYLE = MarkStyle("ground", "s", 130.0, edge=PALE_INK, hatch="//////")
POINT_STYLE = MarkStyle("point of a body", "o", 5.0, face=INK)
MASS_STYLE = MarkStyle("mass", "o", 16.0, face=COLOURS[5])
CENTRE_STYLE = MarkStyle("centre of mass", "o", 9.0, face=COLOURS[5])
_JOINT_STYLES = MappingProxyType(
    {
        "Fixed": MarkStyle("fixed", "s", face=INK),
        "Ball": MarkStyle("ball", "o", face=INK),
        "Revolute": MarkStyle("revolute", "o"),
        "Universal": MarkStyle("universal", "X"),
        "Cylindrical": MarkStyle("cylindrical", "h"),
        "Prismatic": MarkStyle("prismatic", "s"),
        "PrescribedRotation": MarkStyle("prescribed rotation", "o", face=COLOURS[1]),
        "PrescribedTranslation": MarkStyle("prescribed translation", "s", face=COLOURS[1]),
    }
)


class Mark(NamedTuple):
    """Marks of one style at a point (t, 3), or at several points (t, k, 3)."""

    style: MarkStyle
    places: FloatArray


@dataclass(frozen=True, eq=False)
class Glyphs:
    """Lines (t, s, 2, 3) from point to point, marks, and thin lines, at t times of a motion."""

    lines: FloatArray
    marks: tuple[Mark, ...]
    thin_lines: FloatArray | None = None
    """Springs and ties of meshes, and outlines of walls, (t, k, 2, 3)"""

    @property
    def is_empty(self) -> bool:
        """Whether there are neither marks nor lines."""
        return not self.marks and not self.lines.shape[1] and self.thin_lines is None

    @property
    def points(self) -> FloatArray:
        """All points (t, k, 3)."""
        drawn = [self.lines, *(mark.places for mark in self.marks)]
        drawn += [] if self.thin_lines is None else [self.thin_lines]
        return np.concatenate([each.reshape(len(self.lines), -1, 3) for each in drawn], axis=1)

    @property
    def legend_rows(self) -> int:
        """Rows of the legend of the marks."""
        return -(-len({mark.style.name for mark in self.marks}) // LEGEND_COLUMNS)

    def beside(self, others: Sequence[Glyphs]) -> Glyphs:
        """These glyphs and others at the same times."""
        everything = (self, *others)
        thin = [each.thin_lines for each in everything if each.thin_lines is not None]
        return Glyphs(
            np.concatenate([each.lines for each in everything], axis=1),
            tuple(mark for each in everything for mark in each.marks),
            np.concatenate(thin, axis=1) if thin else None,
        )


def glyphs_of(system: System, solution: Solution, rows: slice | NDArray[np.int64]) -> Glyphs:
    """Rigid bodies, joints and ground at some output times of a run.

    A rigid body is drawn as lines from its centre of mass to its interfaces. A joint is drawn at its second
    end. A joint to the ground is drawn at its moving end, and the ground at the initial position of this end.
    """
    lines: list[FloatArray] = []
    marks: list[Mark] = []
    n_times = len(solution.times[rows])
    for name, body in system.bodies_of(RigidBody).items():
        motion = solution.motion(name, FloatingMotion).at(rows)
        centre = in_space(motion.position, motion.rotation, body.centre[None, None])
        ends = body.positions(motion)
        lines.append(np.stack([np.broadcast_to(centre, ends.shape), ends], axis=2))
        marks.append(Mark(CENTRE_STYLE, centre[:, 0]))
    for joint in system.joints:
        marks += _joint_marks(system, solution, joint, rows, n_times)
    joined = np.concatenate(lines, axis=1) if lines else np.empty((n_times, 0, 2, 3))
    return Glyphs(joined, tuple(sorted(marks, key=lambda mark: -mark.style.size)))


def surface_glyphs(surface: BodySurface, nodes: FloatArray) -> Glyphs | None:
    """Glyphs of the links and masses of a body with nodes at (t, N, 3); None if the body has neither."""
    if not (len(surface.links) or len(surface.masses)):
        return None
    marks = (Mark(MASS_STYLE, nodes[:, surface.masses]),) if len(surface.masses) else ()
    return Glyphs(np.empty((len(nodes), 0, 2, 3)), marks, nodes[:, surface.links])


def _joint_marks(
    system: System, solution: Solution, joint: Joint, rows: slice | NDArray[np.int64], n_times: int
) -> Iterator[Mark]:
    drawn, other = (joint.second, joint.first)
    if drawn == GROUND:
        drawn, other = other, drawn
    if other == GROUND:
        yield Mark(GROUND_STYLE, np.tile(system.initial_point(drawn), (n_times, 1)))
    style = _JOINT_STYLES.get(type(joint).__name__, MarkStyle(type(joint).__name__, "P"))
    motion = solution.bodies[drawn.body].at(rows)
    yield Mark(style, tracked_motion(system.placed(drawn.body).body, motion, drawn.interface).position)


class DrawnGlyphs:
    """Drawn glyphs, which can be moved from one time to the next."""

    def __init__(self, axes: Axes, glyphs: Glyphs, camera: Camera) -> None:
        self._lines = camera.project(glyphs.lines)[0]
        self._places = [camera.project(mark.places)[0] for mark in glyphs.marks]
        self._drawn_lines = LineCollection([], colors=INK, linewidths=2.2, capstyle="round", zorder=2.4)
        axes.add_collection(self._drawn_lines, autolim=False)
        thin = np.empty((len(glyphs.lines), 0, 2, 3)) if glyphs.thin_lines is None else glyphs.thin_lines
        self._thin_lines = camera.project(thin)[0]
        self._drawn_thin = LineCollection([], colors=INK, linewidths=0.7, zorder=2.35)
        axes.add_collection(self._drawn_thin, autolim=False)
        self._marks = [_drawn_mark(axes, mark.style) for mark in glyphs.marks]
        self._styles = [mark.style for mark in glyphs.marks]
        self.show(0)

    def show(self, instant: int) -> None:
        """Move all glyphs to their positions at one of their times."""
        self._drawn_lines.set_segments(list(self._lines[instant]))
        self._drawn_thin.set_segments(list(self._thin_lines[instant]))
        for drawn, places in zip(self._marks, self._places, strict=True):
            drawn.set_offsets(places[instant])

    def legend(self, figure: Figure) -> Legend | None:
        """Legend with one entry per kind of mark, at the bottom of a figure; None without marks."""
        if not self._marks:
            return None
        first = {style.name: drawn for style, drawn in zip(self._styles, self._marks, strict=True)}
        return figure.legend(
            list(first.values()),
            list(first),
            loc="outside lower center",
            ncols=min(LEGEND_COLUMNS, len(first)),
            columnspacing=1.4,
            handletextpad=0.4,
        )


def _drawn_mark(axes: Axes, style: MarkStyle) -> PathCollection:
    return axes.scatter(
        [0.0],
        [0.0],
        s=style.size,
        marker=style.marker,
        facecolors=style.face,
        edgecolors=style.edge,
        linewidths=0.9,
        hatch=style.hatch or None,
        zorder=2.3 if style is GROUND_STYLE else 2.6,
    )
