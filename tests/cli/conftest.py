"""A small case with its mesh: a clamped steel strip under its own weight."""

from __future__ import annotations

import numpy as np
import pytest

from supple.mesh import strip

LENGTH, WIDTH = 1.0, 0.1

CASE = """\
title = "clamped strip"
gravity = [0, 0, -9.81]

[[body]]
name = "strip"
mesh = "strip.inp"
shell = { thickness = 0.01, youngs_modulus = 2.1e11, poissons_ratio = 0.0, density = 7850.0 }
frame = { kind = "mean-axis" }
reduction = { basis = "rubin", modes = 4, derivatives = { kind = "compressed", number = 3 } }
damping = { kind = "rayleigh", alpha = 0.0, beta = 0.02 }

[[body.interface]]
name = "root"
nodes = "ROOT"

[[joint]]
name = "clamp"
kind = "fixed"
first = "ground"
second = "strip.root"

[simulation]
duration = 0.4
output_step = 0.002
step = 0.002

[output]
track = ["strip.TIP", "strip.root"]
pictures = false
animation = false
"""


def abaqus_text(mesh):
    """The mesh in the format of Abaqus, with its root and tip."""
    rows = ["*NODE"]
    rows += [f"{i}, {x:.12g}, {y:.12g}, {z:.12g}" for i, (x, y, z) in enumerate(mesh.nodes, 1)]
    rows.append("*ELEMENT, TYPE=S3, ELSET=ALL")
    (cells,) = mesh.cells.values()
    rows += [f"{i}, {a}, {b}, {c}" for i, (a, b, c) in enumerate(cells + 1, 1)]
    for name in ("root", "tip"):
        rows.append(f"*NSET, NSET={name.upper()}")
        rows.append(", ".join(str(node) for node in np.asarray(mesh.nodes_of(name)) + 1))
    return "\n".join(rows) + "\n"


@pytest.fixture
def case_folder(tmp_path):
    """A folder with `strip.inp` and `strip.toml`."""
    (tmp_path / "strip.inp").write_text(abaqus_text(strip(LENGTH, WIDTH, 8, 2)))
    (tmp_path / "strip.toml").write_text(CASE)
    return tmp_path
