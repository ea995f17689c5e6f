"""A commented case file for a mesh or a machine file: a first case that runs, with every guess marked."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from supple.cases.result_machine import path_from
from supple.errors import ArgumentError
from supple.importers import DECK_SUFFIXES, is_section_file, read_deck, read_mesh, read_section_table
from supple.importers.deck import Deck, IsotropicMaterial
from supple.machine import (
    MUJOCO_SUFFIXES,
    Cylindrical,
    Prismatic,
    Revolute,
    features_not_read,
    read_mujoco,
)
from supple.mesh import CellType, Mesh
from supple.storage.file_errors import file_errors
from supple.units import UnitSystem

__all__ = ["write_new_case"]

SLENDER = 6.0
"""Smallest ratio of the length of a slender body to its next largest size."""
AT_END = 0.01
"""Largest distance of the nodes of a set from the end of a slender body, relative to its length."""
STATIONS = (21, 17, 13, 11, 9, 7, 6, 5)
"""Numbers of stations of a slender body; the first that its mesh supports is chosen."""
OF_A_TABLE = 31
"""Number of stations of a section table."""
OF_A_SLICE = 3
"""Smallest number of nodes of a slice between two cuts halfway between stations."""
OF_FIRST_ORDER = 5_000
"""Largest number of nodes of a mesh that gets mid-edge nodes: tetrahedra have eight times as many then."""


def write_new_case(mesh_file: Path, path: Path) -> None:
    """Write a case of one body to `path`: clamped at a node set of its mesh, loaded by gravity.

    The file may also be a section table, whose body is clamped at its root.

    The node set is the first with three nodes or more, but fewer than half of the nodes; without any set of
    fewer than half, interface and joint are written as comments. A slender mesh with node sets at both ends
    is condensed to stations between them; other bodies are reduced with an allowed error. Every guess is
    marked: units, gravity, clamped set, times, and, unless the file is a deck with properties, material and
    thickness. A URDF or MJCF file becomes a case of its machine, without drives.

    Raises
    ------
    ArgumentError       a file that exists already; a mesh of beams
    ImportFormatError, MeshError    a mesh that cannot be read
    ResultFileError     a file that cannot be written
    """
    if path.exists():
        raise ArgumentError(f"{path} exists already: give another name (-o), or remove it")
    name, named = re.sub(r"[^\w-]", "_", mesh_file.stem), path_from(path.parent, mesh_file)
    if mesh_file.suffix.lower() in MUJOCO_SUFFIXES:
        text = _machine_case(name, named, mesh_file)
    else:
        text = _case(name, named, _read(mesh_file))
    with file_errors("write", path):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, "utf-8")


class _Units(NamedTuple):
    """Consistent units: names, the gravity of the earth, and the number of time units in a second."""

    length: str
    mass: str
    derived: str
    gravity: float
    time: str = "s"
    second: float = 1.0


UNITS = (
    _Units("m", "kg", 'force = "N", stress = "Pa"', 9.81),
    _Units("mm", "t", 'force = "N", stress = "MPa"', 9810.0),
    _Units("in", "lbf*s^2/in", 'force = "lbf", stress = "psi"', 386.1),
    _Units("mm", "kg", 'force = "kN", stress = "GPa"', 9.81e-3, "ms", 1000.0),
)
"""Units among which those of a deck are guessed; the first are those of other meshes."""


@dataclass(frozen=True)
class _Model:
    """Data of a body from its file.

    spans : sizes along the principal axes, the longest first
    sets : names of the sets for supports or output, with fewer than half of the nodes
    root : the first of them with three nodes or more, or the first; None without sets
    tracked : the farthest from `root` of those without a node of `root`; None if there is none
    ends : names of one set at each end of a slender body; None if its mesh is too coarse for stations
    stations : their number, for a body with `ends`
    kind : `solid` or `shell`; `nastran` or `abaqus` where the file has properties; `section_table`
    second_order : whether the mesh has cells of first order that are too stiff in bending
    units : in which the materials of the file are plausible; None without materials, or if no units fit
    """

    spans: tuple[float, float, float]
    sets: Sequence[str]
    root: str | None
    tracked: str | None
    ends: tuple[str, str] | None
    stations: int
    kind: str
    second_order: bool = False
    units: _Units | None = None


def _read(file: Path) -> _Model:
    if is_section_file(file):
        length = float(read_section_table(file).lengths[-1])
        return _Model((length, 0.0, 0.0), (), None, None, ("root", "tip"), OF_A_TABLE, "section_table")
    if file.suffix.lower() in DECK_SUFFIXES:
        deck = read_deck(file)
        if deck.properties or (deck.masses and not deck.elements):
            kind = "abaqus" if file.suffix.lower() == ".inp" else "nastran"
            return replace(_model(deck.nodes, deck.node_sets, kind), units=_units_of(deck))
    mesh = read_mesh(file)
    if CellType.LINE2 in mesh.cells:
        raise ArgumentError(
            f"{file}: the mesh has lines, and a mesh has no cross-sections of beams: give a deck with them "
            "(.bdf, .inp), or write a case with a section_table"
        )
    solid = any(kind.dimension == 3 for kind in mesh.cells)
    model = _model(mesh.nodes, mesh.node_sets, "solid" if solid else "shell")
    return replace(model, second_order=_is_too_stiff(mesh))


def _is_too_stiff(mesh: Mesh) -> bool:
    """Whether more nodes would help: cells of first order, not all HEXA8, in a mesh that may grow."""
    first = all(kind.dimension == 3 and kind.n_nodes == kind.n_corners for kind in mesh.cells)
    return first and set(mesh.cells) != {CellType.HEXA8} and mesh.n_nodes <= OF_FIRST_ORDER


def _units_of(deck: Deck) -> _Units | None:
    """The first units in which modulus and density of every material are those of a solid."""
    known = [getattr(each, "material", None) for each in deck.properties.values()]
    found = {(m.youngs_modulus, m.density) for m in known if isinstance(m, IsotropicMaterial) and m.density}
    for units in UNITS:
        named = UnitSystem(units.length, units.mass, units.time)
        pascal, dense = named.in_si(mass=1, length=-1, time=-2), named.in_si(mass=1, length=-3)
        assert pascal is not None
        assert dense is not None
        if found and all(1e5 < pascal * E < 2e12 and 500 < dense * density < 3e4 for E, density in found):
            return units
    return None


def _model(nodes: np.ndarray, node_sets: Mapping[str, np.ndarray], kind: str) -> _Model:
    sets = {name: own for name, own in node_sets.items() if 0 < len(own) < len(nodes) / 2}
    axes = np.linalg.svd(nodes - nodes.mean(axis=0), full_matrices=False)[2]
    along = nodes @ axes.T
    longest, second, third = (float(each) for each in np.sort(np.ptp(along, axis=0))[::-1])
    stations = _stations(along[:, 0]) if longest >= SLENDER * second else 0
    ends = _ends(along[:, 0], sets) if stations else None
    root = next((name for name, own in sets.items() if len(own) > 2), next(iter(sets), None))
    tracked = None if root is None else _farthest(nodes, sets, root)
    return _Model((longest, second, third), list(sets), root, tracked, ends, stations, kind)


def _farthest(nodes: np.ndarray, sets: Mapping[str, np.ndarray], root: str) -> str | None:
    """The set without a node of `root` that is farthest from it."""
    centre = nodes[sets[root]].mean(axis=0)
    apart = [name for name, own in sets.items() if not np.isin(own, sets[root]).any()]
    away = [float(np.linalg.norm(nodes[sets[name]].mean(axis=0) - centre)) for name in apart]
    return apart[int(np.argmax(away))] if apart else None


def _stations(along: np.ndarray) -> int:
    """The number of stations; 0 if the mesh is too coarse along the axis."""
    place = (along - along.min()) / np.ptp(along)
    for number in STATIONS:
        cuts = (np.arange(number - 1) + 0.5) / (number - 1)
        if np.histogram(place, cuts)[0].min() >= OF_A_SLICE:
            return number
    return 0


def _ends(along: np.ndarray, sets: Mapping[str, np.ndarray]) -> tuple[str, str] | None:
    """The first set at an end of the axis, and the first one at its other end."""
    length = np.ptp(along)

    def at(end: float) -> list[str]:
        return [name for name, own in sets.items() if np.abs(along[own] - end).max() <= AT_END * length]

    low, high = at(along.min()), at(along.max())
    if not low or not high:
        return None
    root, tip = sorted((low[0], high[0]), key=list(sets).index)
    return root, tip


def _case(name: str, named: str, model: _Model) -> str:
    units = model.units or UNITS[0]
    why = "units of the moduli and densities in the file; " if model.units else ""
    return f"""\
# {name} under its weight. Check the lines marked GUESS; `supple info {named}` lists sets and sizes.

title = "{name} under its weight"
# GUESS: {why}the body is {model.spans[0]:.4g} long;
# nothing is converted, so file and case need the same units.
units = {{ length = "{units.length}", mass = "{units.mass}", time = "{units.time}", {units.derived} }}
gravity = [0.0, 0.0, -{units.gravity}]   # GUESS

[[body]]
name = "{name}"
{_source(named, model)}
{_reduction(model)}

{_support(name, model)}
[simulation]
duration = {units.second}       # GUESS
output_step = {units.second / 100}   # GUESS: at least ten per period of the motion of interest
step = {units.second / 100}          # GUESS: the report states its error
start = "equilibrium"

# A load besides the weight, at a node set or an interface:
# [[load]]
# kind = "force"
# at = "{name}.{"SET" if model.ends is None else "tip"}"
# vector = [0.0, 0.0, 1000.0]
# law = {{ kind = "ramp", value = 1.0, duration = {units.second / 2} }}
{_output(name, model)}"""


def _reduction(model: _Model) -> str:
    if model.ends is not None:
        return f"""\
# A slender body: stations along its length, for bending of any size. Other bodies take frame and reduction.
condense = {{ root = "root", tip = "tip", stations = {model.stations}, modes = 12 }}"""
    basis = "craig-bampton" if model.sets else "normal-modes"
    return f"""\
frame = {{ kind = "mean-axis" }}
# Tolerance, step and basis are refined until the estimated error is at most 1e-3 of the largest displacement.
reduction = {{ basis = "{basis}", accuracy = {{ relative = 1e-3 }} }}"""


def _source(named: str, model: _Model) -> str:
    if model.kind == "section_table":
        return f'section_table = "{named}"   # stiffness and inertia of the sections'
    return f'mesh = "{named}"\n{_material(model)}'


def _material(model: _Model) -> str:
    steel = "youngs_modulus = 210.0e9, poissons_ratio = 0.3, density = 7850.0"
    if model.kind == "solid":
        if model.second_order:
            given = f"solid = {{ {steel}, second_order = true }}"
            return (
                f"# GUESS: steel. First-order cells are too stiff; second_order adds mid-edge nodes.\n{given}"
            )
        return f"solid = {{ {steel} }}   # GUESS: steel"
    if model.kind == "shell":
        wall = f"thickness = {model.spans[1] / 100:.3g}"
        return f"# GUESS: steel, a hundredth of its width thick\nshell = {{ {wall}, {steel} }}"
    return f"{model.kind} = {{}}   # materials, sections and connections are those of the file"


def _support(name: str, model: _Model) -> str:
    known = (
        ", ".join(model.sets[:20]) or "none: name the nodes in the mesher, or give node_indices = [..] here"
    )
    root, tip = model.ends or (model.root or "SET", None)
    if model.kind == "section_table":
        return f"""\
# The first and the last station; a further interface has node_indices = [NUMBER OF ITS STATION].
[[body.interface]]
name = "root"

[[body.interface]]
name = "tip"

{_joint(name)}"""
    held = f"""\
# Node sets with fewer than half of the nodes (at most 20): {known}
[[body.interface]]
name = "root"
nodes = "{root}"   # GUESS: where the body is clamped
"""
    if tip is not None:
        held += f"""
[[body.interface]]
name = "tip"
nodes = "{tip}"
kind = "averaging"   # its section may deform
"""
    held += "\n" + _joint(name)
    if model.sets:
        return held
    return "".join(
        f"{line if line.startswith('#') else f'# {line}'.rstrip()}\n" for line in held.splitlines()
    )


def _joint(name: str) -> str:
    return f"""\
[[joint]]
name = "support"
kind = "fixed"
first = "ground"
second = "{name}.root"
"""


def _output(name: str, model: _Model) -> str:
    """The table [output], which tracks the tip or a set apart from the clamped one; empty without them."""
    place = "tip" if model.ends is not None else model.tracked
    return f'\n[output]\ntrack = ["{name}.{place}"]\n' if place else ""


def _machine_case(name: str, named: str, file: Path) -> str:
    """Text of a case of the machine in a URDF or MJCF file, which the case names `named`."""
    left = features_not_read(file)
    machine = read_mujoco(file, leave_out=left)
    joints = [each for each in machine.joints if isinstance(each, Revolute | Prismatic | Cylindrical)]
    lines = ["", "# Its bodies and joints: supple info of this file."]
    if left:
        words = ", ".join(f'"{each}"' for each in left)
        lines[:0] = [
            f"leave_out = [{words}]   # GUESS: parts of the file that affect its motion and are not read"
        ]
    for joint in joints[:1]:
        kind = "slide-servo" if isinstance(joint, Prismatic) else "angle-servo"
        axis = ", ".join(f"{each:.6g}" for each in joint.axis)
        lines += [
            "",
            "# A drive, one for each joint; joints without a drive move freely:",
            "# [[element]]",
            f'# kind = "{kind}"',
            f'# name = "{joint.name} drive"',
            f'# first = "{joint.first}"',
            f'# second = "{joint.second}"',
            f"# axis = [{axis}]",
            '# law = { kind = "ramp", value = 0.5, duration = 1.0 }',
            "# stiffness = 100.0",
            "# damping = 10.0",
        ]
    more, body = "\n".join(lines), machine.bodies[-1].body.name
    return f"""\
# The machine of {named}. Check the lines marked GUESS.

title = "{name}"
units = {{ length = "m", mass = "kg", time = "s" }}

[machine]
mujoco = "{named}"
{more}

# A flexible body or further interfaces for a body of the file:
# [[body]]
# name = "{body}"
# interface = [{{ name = "tool", position = [0.1, 0.0, 0.0] }}]
{"".join(_joint_sensor(joint.name) for joint in joints)}
[simulation]
duration = 1.0       # GUESS
output_step = 0.01   # GUESS: at least ten per period of the motion of interest
step = 0.001         # GUESS: compare with half of it
"""


def _joint_sensor(joint: str) -> str:
    return f"""
[[sensor]]
name = "{joint}"
kind = "joint-motion"
joint = "{joint}"
"""
