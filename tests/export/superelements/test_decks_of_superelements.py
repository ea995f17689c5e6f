"""CalculiX runs a superelement; what Abaqus is given is read back."""

import re
import shutil
import subprocess

import numpy as np
import pytest

from supple.body import MeanAxisFrame, RigidInterface, flexible_body
from supple.export import interface_form, write_abaqus_superelement, write_calculix_superelement
from supple.fem import Isotropic, solid_model
from supple.mesh import CellType, block
from supple.reduction import CraigBampton, NoDerivatives, NoLoads, reduce


def step(n):
    return f"*STEP\n*FREQUENCY\n{n}\n*END STEP\n"


def calculix_frequencies(folder, name):
    """Cycles per unit of time, of a deck that CalculiX runs there."""
    subprocess.run(["ccx", name], cwd=folder, check=True, capture_output=True)
    rows = re.findall(r"^\s+\d+((?:\s+[\d.E+-]+){4})$", (folder / f"{name}.dat").read_text(), re.M)
    return [float(row.split()[2]) for row in rows]


@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX (ccx) is not installed")
@pytest.mark.parametrize("held", [["root"], ["far tip/µ"]])
def test_calculix_finds_the_frequencies_that_the_deck_states(form, tmp_path, held):
    deck = write_calculix_superelement(tmp_path / "part.inp", form)
    number = form.interfaces.index(held[0])
    clamp = f"*INCLUDE, INPUT={deck.name}\n*BOUNDARY\n{2 * number + 1}, 1, 3\n{2 * number + 2}, 1, 3\n"
    (tmp_path / "run.inp").write_text(clamp + step(2))
    np.testing.assert_allclose(
        calculix_frequencies(tmp_path, "run")[:2], form.frequencies(held)[:2], rtol=1e-6
    )


def test_the_deck_of_equations_makes_the_same_matrices(form, tmp_path):
    """Masses 1 and the springs, with the equations solved for the dependent coordinates."""
    lines = write_calculix_superelement(tmp_path / "part.inp", form).read_text().splitlines()
    n, nodes = len(form.mass), 2 * len(form.interfaces)
    coordinates = {(nodes + 1 + k // 3, k % 3 + 1): k for k in range(n)}
    boundary = {(1 + k // 3, k % 3 + 1): k for k in range(form.n_boundary)}
    springs = np.zeros(n)
    for at in [k for k, line in enumerate(lines) if line.startswith("*ELEMENT, TYPE=SPRING1")]:
        node, component = int(lines[at + 1].split(",")[1]), int(lines[at + 3])
        springs[coordinates[node, component]] = float(lines[at + 4])
    T, dependent = {}, []
    for at in [k for k, line in enumerate(lines) if line == "*EQUATION"]:
        terms, count = [], 3 * int(lines[at + 1])
        for line in lines[at + 2 :]:
            terms += [word for word in line.split(",") if word.strip()]
            if len(terms) >= count:
                break
        triples = [(int(a), int(b), float(c)) for a, b, c in zip(*[iter(terms)] * 3, strict=True)]
        (node, component, factor), *others = triples
        assert factor == -1.0
        dependent.append(coordinates[node, component])
        T[dependent[-1]] = others
    free = [k for k in range(n) if k not in dependent]
    assert len(dependent) == form.n_boundary
    whole = np.zeros((n, n))
    for k in range(n):
        if k in T:
            for node, component, value in T[k]:
                at = (node, component)
                whole[
                    k, boundary[at] if at in boundary else form.n_boundary + free.index(coordinates[at])
                ] = value
        else:
            whole[k, form.n_boundary + free.index(k)] = 1.0
    K, M = whole.T @ np.diag(springs) @ whole, whole.T @ whole
    b = form.n_boundary
    condensed = K[:b, :b] - K[:b, b:] @ np.linalg.solve(K[b:, b:], K[b:, :b])
    scale = np.sqrt(np.diag(form.stiffness)[:b])
    assert abs((condensed - form.stiffness[:b, :b]) / np.outer(scale, scale)).max() < 1e-7
    assert np.linalg.eigvalsh(M)[0] > 0


def test_matrices_for_abaqus_are_read_back(form, tmp_path):
    text = write_abaqus_superelement(tmp_path / "part.inp", form).read_text()
    n = len(form.mass)
    rows = {(i + 1, k + 1): 6 * i + k for i in range(len(form.interfaces)) for k in range(6)}
    rows |= {(len(form.interfaces) + 1 + m, 1): form.n_boundary + m for m in range(form.n_modal)}
    for name in ("STIFFNESS", "MASS", "DAMPING"):
        block = re.search(rf"NAME=SUPPLE_{name}, TYPE=SYMMETRIC\n([^*]+)", text)[1]
        matrix = np.zeros((n, n))
        for line in block.split("\n")[:-1]:
            a, b, c, d, value = line.split(",")
            i, j = rows[int(a), int(b)], rows[int(c), int(d)]
            matrix[i, j] = matrix[j, i] = float(value)
        np.testing.assert_array_equal(matrix, getattr(form, name.lower()))
    assert text.rstrip().endswith("VISCOUS DAMPING=SUPPLE_DAMPING")


def meshed(mesh, first, shift):
    """A steel block of solids from `first`, moved along x; sets ROOT and TIP with its number."""
    lines = ["*NODE"]
    lines += [f"{first + i}, {x + shift:.12e}, {y:.12e}, {z:.12e}" for i, (x, y, z) in enumerate(mesh.nodes)]
    lines.append(f"*ELEMENT, TYPE=C3D10, ELSET=E{first}")
    cells = mesh.cells[CellType.TETRA10] + first
    lines += [", ".join(map(str, (first + i, *cell))) for i, cell in enumerate(cells)]
    for name in ("root", "tip"):
        lines += [f"*NSET, NSET={name.upper()}{first}", *(f"{n + first}," for n in mesh.nodes_of(name))]
    return [*lines, f"*SOLID SECTION, ELSET=E{first}, MATERIAL=STEEL"]


STEEL = ["*MATERIAL, NAME=STEEL", "*ELASTIC", "2.1e11, 0.3", "*DENSITY", "7800."]


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX (ccx) is not installed")
def test_half_a_beam_beside_its_other_half_in_solids(tmp_path):
    """In CalculiX: the superelement of one half, joined to the mesh of the other, against two meshes."""
    mesh = block(1.0, 0.2, 0.1, 6, 2, 1, CellType.TETRA10)
    model = solid_model(mesh, Isotropic(2.1e11, 0.3, 7800.0))
    half = flexible_body("half", model, [RigidInterface(name, name) for name in ("root", "tip")]).linearized()
    basis, none = CraigBampton(n_modes=20), NoDerivatives()
    reduced = reduce(half, MeanAxisFrame(), basis, derivatives=none, loads=NoLoads)
    write_calculix_superelement(tmp_path / "part.inp", interface_form(reduced))
    clamped = ["*BOUNDARY", "1, 1, 3", "2, 1, 3", step(8)]
    outer = [*STEEL, *meshed(mesh, 3001, 1.0)]
    joined = ["*RIGID BODY, NSET=ROOT3001, REF NODE=3, ROT NODE=4", *clamped]
    inner = ["*NODE", *(f"{n}, {x}, 0, 0" for n, x in ((1, 0), (2, 0), (3, 1), (4, 1), (5, 1), (6, 1)))]
    inner += meshed(mesh, 1001, 0.0)
    inner += [
        "*RIGID BODY, NSET=ROOT1001, REF NODE=1, ROT NODE=2",
        "*RIGID BODY, NSET=TIP1001, REF NODE=5, ROT NODE=6",
    ]
    for node, other in ((5, 3), (6, 4)):
        for k in (1, 2, 3):
            inner += ["*EQUATION", "2", f"{node}, {k}, 1.0, {other}, {k}, -1.0"]
    found = []
    for name, first in (("one", ["*INCLUDE, INPUT=part.inp"]), ("two", inner)):
        (tmp_path / f"{name}.inp").write_text("\n".join([*first, *outer, *joined]))
        found.append(calculix_frequencies(tmp_path, name)[:8])
    np.testing.assert_allclose(*found, rtol=1e-4)
