"""A commented case file for a mesh: a first case that runs, with every guess marked."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from supple.cases.result_machine import path_from
from supple.errors import ArgumentError
from supple.importers import DECK_SUFFIXES, read_deck, read_mesh
from supple.storage.file_errors import file_errors

__all__ = ["write_new_case"]


def write_new_case(mesh_file: Path, path: Path) -> None:
    """Write a case of one body to `path`: clamped at a node set of its mesh, loaded by gravity.

    The node set is the first with fewer than half of the nodes; without such a set, interface and joint are
    written as comments. Every guess is marked: units, gravity, clamped set, times, and, unless the file is a
    deck with properties, material and thickness.

    Raises
    ------
    ArgumentError       a file that exists already
    ImportFormatError, MeshError    a mesh that cannot be read
    ResultFileError     a file that cannot be written
    """
    if path.exists():
        raise ArgumentError(f"{path} exists already: give another name (-o), or remove it")
    model = _read(mesh_file)
    text = _case(re.sub(r"[^\w-]", "_", mesh_file.stem), path_from(path.parent, mesh_file), model)
    with file_errors("write", path):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, "utf-8")


@dataclass(frozen=True)
class _Model:
    """Data of a body from its file."""

    size: float
    sets: Sequence[str]
    kind: str
    """`solid` or `shell`; `nastran` or `abaqus` where the file has properties"""


def _read(file: Path) -> _Model:
    if file.suffix.lower() in DECK_SUFFIXES:
        deck = read_deck(file)
        if deck.properties:
            kind = "abaqus" if file.suffix.lower() == ".inp" else "nastran"
            return _Model(_size(deck.nodes), _places(deck.node_sets, len(deck.nodes)), kind)
    mesh = read_mesh(file)
    solid = any(kind.dimension == 3 for kind in mesh.cells)
    places = _places(mesh.node_sets, len(mesh.nodes))
    return _Model(_size(mesh.nodes), places, "solid" if solid else "shell")


def _places(sets: Mapping[str, np.ndarray], n_nodes: int) -> list[str]:
    """Names of the sets for supports or output, with fewer than half of the nodes."""
    return [name for name, nodes in sets.items() if 0 < len(nodes) < n_nodes / 2]


def _size(nodes: np.ndarray) -> float:
    return float(np.max(np.ptp(nodes, axis=0)))


def _case(name: str, named: str, model: _Model) -> str:
    basis = "craig-bampton" if model.sets else "normal-modes"
    return f"""\
# {name} under its weight. Lines marked GUESS are yours to set; `supple info {named}` lists sets and sizes.

title = "{name} under its weight"
# GUESS: the mesh is {model.size:.4g} long; nothing is converted, so mesh and numbers need the same units.
units = {{ length = "m", mass = "kg", time = "s", force = "N", stress = "Pa" }}
gravity = [0.0, 0.0, -9.81]   # GUESS

[[body]]
name = "{name}"
mesh = "{named}"
{_material(model)}
frame = {{ kind = "mean-axis" }}
# Tolerance, step and basis are refined until the estimated error is at most 1e-3 of the largest displacement.
reduction = {{ basis = "{basis}", accuracy = {{ relative = 1e-3 }} }}

{_support(name, model.sets)}
[simulation]
duration = 1.0       # GUESS
output_step = 0.01   # GUESS: at least ten per period of the motion of interest
step = 0.01          # GUESS: the report states its error
start = "equilibrium"

# A load besides the weight, at a node set or an interface:
# [[load]]
# kind = "force"
# at = "{name}.SET"
# vector = [0.0, 0.0, 1000.0]
# law = {{ kind = "ramp", value = 1.0, duration = 0.5 }}
{_output(name, model.sets)}"""


def _material(model: _Model) -> str:
    steel = "youngs_modulus = 210.0e9, poissons_ratio = 0.3, density = 7850.0"
    if model.kind == "solid":
        return f"solid = {{ {steel} }}   # GUESS: steel"
    if model.kind == "shell":
        wall = f"thickness = {model.size / 100:.3g}"
        return f"# GUESS: steel, a hundredth of its length thick\nshell = {{ {wall}, {steel} }}"
    return f"{model.kind} = {{}}   # materials, sections and connections are those of the file"


def _support(name: str, sets: Sequence[str]) -> str:
    known = ", ".join(sets[:20]) or "none: name the nodes in the mesher, or give node_indices = [..] here"
    held = f"""\
# Node sets with fewer than half of the nodes (at most 20): {known}
[[body.interface]]
name = "root"
nodes = "{sets[0] if sets else "SET"}"   # GUESS: where the body is clamped

[[joint]]
name = "support"
kind = "fixed"
first = "ground"
second = "{name}.root"
"""
    if sets:
        return held
    return (
        "\n".join(f"# {line}".rstrip() if not line.startswith("#") else line for line in held.splitlines())
        + "\n"
    )


def _output(name: str, sets: Sequence[str]) -> str:
    """The table [output], which tracks the last set; empty without a second set, as the first is clamped."""
    return f'\n[output]\ntrack = ["{name}.{sets[-1]}"]\n' if len(sets) > 1 else ""
