"""Draw the pictures of the how-tos: an interface, the axes of a joint, and the effect of `seen_from`.

python tools/site/how_to_pictures.py docs/pictures
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from supple.mesh import CellType, block, skin_of
from supple.results.camera import Camera
from supple.units import UNNAMED
from supple.viz.glyphs import MASS_STYLE, Glyphs, Mark
from supple.viz.mesh_plot import draw_surface
from supple.viz.style import COLOURS, INK, new_figure, save_figure, textbook_style

RESOLUTION = {"savefig.dpi": 100}


def interface(folder: Path) -> None:
    """A virtual node tied to the nodes of the end of a bar."""
    mesh = block(1.0, 0.2, 0.2, 10, 2, 2, CellType.HEXA8)
    end = mesh.nodes[np.isclose(mesh.nodes[:, 0], mesh.nodes[:, 0].max())]
    virtual = end.mean(axis=0) + np.array([0.25, 0.0, 0.0])
    spokes = np.stack([np.broadcast_to(virtual, end.shape), end], axis=1)
    glyphs = Glyphs(np.empty((1, 0, 2, 3)), (Mark(MASS_STYLE, virtual[None]),), spokes[None])
    figure, axes, camera = draw_surface(
        mesh.nodes,
        skin_of(mesh),
        colour_by=None,
        undeformed=None,
        glyphs=glyphs,
        camera=Camera.looking(along=[-0.55, 0.75, -0.4], up=[0, 0, 1]),
        title="Interface: a virtual node tied to the nodes of a set",
        units=UNNAMED,
    )
    _remove_legend(figure)
    _label(axes, camera, virtual, "virtual node: joints and\nforces act here", (8, 10), "left")
    _label(axes, camera, end[0], "node set", (-14, -18), "right")
    save_figure(figure, folder / "interface.png")


def joint_axes(folder: Path) -> None:
    """The axes of a hinge, fixed to its first end, and the angle of its second end."""
    figure = new_figure(2.6)
    axes = figure.subplots()
    angle = np.radians(35.0)
    first, second = np.eye(2), np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    axes.plot([-1.3, 0], [0, 0], color=COLOURS[0], linewidth=5, solid_capstyle="round")
    axes.plot([0, 1.5 * second[0, 0]], [0, 1.5 * second[0, 1]], color=COLOURS[1], linewidth=5)
    axes.text(-1.3, 0.1, "first", color=COLOURS[0])
    axes.text(*(1.55 * second[0]), "second", color=COLOURS[1], va="center")
    beside_the_bar = second[0] - 0.14 * second[1]
    for tip, place, style, name in (
        (first[0], 1.06 * first[0], "-", "$x_1$"),
        (first[1], 1.06 * first[1], "-", "$y_1$"),
        (second[0], beside_the_bar, "--", "$x_2$"),
        (second[1], 1.06 * second[1], "--", "$y_2$"),
    ):
        arrow = {"arrowstyle": "->", "linestyle": style, "color": INK}
        axes.annotate("", 0.9 * tip, (0.0, 0.0), arrowprops=arrow, zorder=3)
        axes.text(*place, name, ha="center", va="center")
    arc = np.linspace(0.0, angle, 30)
    axes.plot(0.55 * np.cos(arc), 0.55 * np.sin(arc), color=INK)
    axes.text(0.62 * np.cos(angle / 2), 0.62 * np.sin(angle / 2), "angle", va="center")
    axes.scatter([0.0], [0.0], s=60, facecolors="white", edgecolors=INK, zorder=4)
    axes.scatter([0.0], [0.0], s=8, color=INK, zorder=5)
    axes.text(0.0, -0.28, "$z$ (the key `axis`), towards the viewer", ha="center")
    axes.set_title("Axes of a hinge: equal at the start; joint forces are along those of the first end")
    axes.set_aspect("equal")
    axes.set_xlim(-1.6, 2.1)
    axes.set_ylim(-0.45, 1.2)
    axes.set_axis_off()
    save_figure(figure, folder / "joint_axes.png")


def seen_from(folder: Path) -> None:
    """One bent bar on a hinge, and its deflection relative to either end."""
    figure = new_figure(2.9)
    axes = figure.subplots()
    s = np.linspace(0.0, 1.0, 60)
    bend, turn = 0.22 * s**2, np.radians(25.0)
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    bent = rotation @ np.stack([s, bend])
    root = rotation @ np.stack([s, 0.0 * s])
    slope = np.array([1.0, 0.44]) / np.hypot(1.0, 0.44)
    tip = rotation @ (np.array([[1.0], [0.22]]) + np.outer(slope, s - 1.0))
    axes.plot(s, 0 * s, color="0.75", linewidth=4, label="at the start")
    axes.plot(*bent, color=COLOURS[0], linewidth=4, label="bent, on its hinge")
    axes.plot(*root, color=INK, linestyle="--", label='undeformed, moved with "bar.root"')
    axes.plot(*tip, color=COLOURS[1], linestyle="--", label='undeformed, moved with "bar.tip"')
    for straight, k, colour, name in ((root, -1, INK, "tip"), (tip, 0, COLOURS[1], "root")):
        arrow = {"arrowstyle": "->", "color": colour, "linewidth": 1.4}
        axes.annotate("", bent[:, k], straight[:, k], arrowprops=arrow, zorder=4)
        middle = (bent[:, k] + straight[:, k]) / 2
        axes.annotate(
            f"deflection of the {name}",
            middle,
            xytext=(8, -2) if k else (14, -18),
            textcoords="offset points",
            color=colour,
        )
    axes.scatter([0.0], [0.0], s=50, facecolors="white", edgecolors=INK, zorder=5)
    axes.set_title("seen_from: the interface against which a deflection is measured")
    axes.legend(loc="upper left", frameon=False)
    axes.set_aspect("equal")
    axes.set_xlim(-0.35, 1.55)
    axes.set_ylim(-0.3, 0.85)
    axes.set_axis_off()
    save_figure(figure, folder / "seen_from.png")


def _label(
    axes: Axes, camera: Camera, point: np.ndarray, text: str, offset: tuple[int, int], side: str
) -> None:
    axes.annotate(
        text,
        camera.project(point)[0],
        xytext=offset,
        textcoords="offset points",
        ha=side,
        fontsize=8,
        zorder=5,
        arrowprops={"arrowstyle": "-", "color": INK, "linewidth": 0.6},
    )


def _remove_legend(figure: Figure) -> None:
    for legend in figure.legends:
        legend.remove()


if __name__ == "__main__":
    for draw in (interface, joint_axes, seen_from):
        with textbook_style(), mpl.rc_context(RESOLUTION):
            draw(Path(sys.argv[1]))
