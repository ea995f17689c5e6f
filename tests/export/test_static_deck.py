"""Static decks: our own reader finds the mesh again, and the loads add up."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from fixtures.solid_blocks import solid_block

from supple.body import RigidInterface, flexible_body
from supple.errors import ModelError
from supple.export import ABAQUS, CALCULIX, resultant, static_load, write_static_deck
from supple.fem import (
    Anisotropic,
    Attached,
    BeamSection,
    HomogeneousSection,
    Isotropic,
    LaminateSection,
    Section,
    finite_element_model,
    linear_strains,
    shell_model,
    solid_model,
)
from supple.importers import read_mesh
from supple.machine import DeadForce, FollowerForce, Ramp, Scaled
from supple.machine.laws.turning import Turning
from supple.mesh import CellType, Mesh, block, box_beam, strip

STEEL = Isotropic(2.1e11, 0.3, 7850.0)
LENGTH, WIDTH, HEIGHT, WALL = 2.0, 0.4, 0.3, 0.01


@pytest.fixture
def box():
    return shell_model(box_beam(LENGTH, WIDTH, HEIGHT, 4, 2, 2), HomogeneousSection(STEEL, WALL))


def lines_below(text, keyword):
    """Numbers of the data lines of a keyword."""
    found = re.search(rf"^\*{keyword}\b[^\n]*\n((?:[^*\n][^\n]*\n)*)", text, re.MULTILINE)
    assert found
    return [[float(word) for word in line.strip(",").split(",")] for line in found[1].splitlines()]


def loads_in(text, n):
    """(n, 6), what *CLOAD puts on the first n nodes."""
    loads = np.zeros((n, 6))
    for node, freedom, value in lines_below(text, "CLOAD"):
        loads[int(node) - 1, int(freedom) - 1] += value
    return loads


@pytest.mark.parametrize(
    ("kind", "option", "name"),
    [(CellType.HEXA8, "incompatible", "C3D8I"), (CellType.HEXA20, "reduced", "C3D20R")],
)
def test_the_element_is_named_as_it_is(kind, option, name, tmp_path):
    mesh = block(1.0, 0.4, 0.3, 1, 1, 1, kind)
    model = finite_element_model(mesh, (Section(kind, np.arange(1), STEEL, **{option: True}),))
    load = np.ones_like(mesh.nodes)
    text = write_static_deck(tmp_path / "solid.inp", model, load, mesh.nodes_of("root")).read_text()
    assert f"TYPE={name}," in text


@pytest.mark.parametrize("kind", [CellType.TETRA4, CellType.TETRA10, CellType.HEXA8, CellType.HEXA20])
def test_a_solid_is_read_back_as_it_was(kind, tmp_path):
    model = solid_model(block(1.0, 0.4, 0.3, 3, 2, 1, kind), STEEL)
    mesh = model.mesh
    loads = np.random.default_rng(0).normal(size=mesh.nodes.shape)
    path = write_static_deck(tmp_path / "solid.inp", model, loads, mesh.nodes_of("root"))
    again = read_mesh(path)
    np.testing.assert_allclose(again.nodes, mesh.nodes, rtol=1e-12)
    np.testing.assert_array_equal(again.cells[kind], mesh.cells[kind])
    for name, nodes in mesh.node_sets.items():
        np.testing.assert_array_equal(np.sort(again.nodes_of(name)), np.sort(nodes))
    np.testing.assert_array_equal(np.sort(again.nodes_of("SUPPLE_CLAMPED")), np.sort(mesh.nodes_of("root")))
    text = path.read_text()
    np.testing.assert_allclose(loads_in(text, mesh.n_nodes)[:, :3], loads, rtol=1e-12)
    # CalculiX reads twenty characters of a number.
    assert max(len(word) for word in re.findall(r"[-+.\de]+", text)) <= 20


def test_a_shell_for_abaqus_is_read_back_with_its_sections(tmp_path):
    """Two walls, a set name that Abaqus would not take, and one element for each triangle."""
    mesh = strip(1.0, 0.2, 4, 2)
    triangles = mesh.cells[CellType.TRIANGLE3]
    thick = np.arange(len(triangles)) < 6
    mesh = Mesh(
        mesh.nodes,
        mesh.cells,
        {"the tip": mesh.nodes_of("tip"), "root": mesh.nodes_of("root")},
        {
            "thick": {CellType.TRIANGLE3: np.flatnonzero(thick)},
            "thin": {CellType.TRIANGLE3: np.flatnonzero(~thick)},
        },
    )
    wall = {"thick": HomogeneousSection(STEEL, 0.02), "thin": HomogeneousSection(STEEL, 0.004)}
    model = shell_model(mesh, wall)
    load = np.zeros((mesh.n_nodes, 6))
    load[mesh.nodes_of("the tip")] = [0, 0, 1.0, 0, 0.5, 0]
    path = write_static_deck(
        tmp_path / "walls.inp", model, load, mesh.nodes_of("root"), program=ABAQUS, title="Größe"
    )
    again = read_mesh(path)
    # Elements stand section by section, numbered as in the mesh.
    order = np.concatenate([section.cells for section in model.sections])
    np.testing.assert_array_equal(again.cells[CellType.TRIANGLE3], triangles[order])
    np.testing.assert_array_equal(again.nodes_of("the_tip"), mesh.nodes_of("the tip"))
    assert len(again.cells_of("SUPPLE_SECTION_2")[CellType.TRIANGLE3]) == (~thick).sum()
    text = path.read_text()
    assert text.startswith("*HEADING\nGr?")
    assert re.findall(r"\*SHELL SECTION.*\n(.*)", text) == ["0.02", "0.004"]
    assert "SUPPLE_CLAMPED, 1, 6" in text
    np.testing.assert_array_equal(loads_in(text, mesh.n_nodes), load)


def test_a_shell_for_calculix_has_a_node_on_the_middle_of_every_side(box, tmp_path):
    mesh = box.mesh
    load = np.zeros((mesh.n_nodes, 6))
    load[mesh.nodes_of("tip"), 2] = 1.0
    path = write_static_deck(tmp_path / "box.inp", box, load, mesh.nodes_of("root"), program=CALCULIX)
    text = path.read_text()
    assert "TYPE=S6" in text
    nodes = np.array(lines_below(text, "NODE"))[:, 1:]
    elements = np.array(lines_below(text, "ELEMENT"), dtype=int)[:, 1:] - 1
    np.testing.assert_array_equal(elements[:, :3], mesh.cells[CellType.TRIANGLE3])
    corners = nodes[elements[:, :3]]
    middles = (corners + np.roll(corners, -1, axis=1)) / 2
    np.testing.assert_allclose(nodes[elements[:, 3:]], middles, atol=1e-15)
    # A node for each side and no more: a closed tube of quads cut in two has V - E + F = 0.
    assert len(nodes) == 2 * mesh.n_nodes + len(elements)
    # The ring is clamped all around, the middle of its sides with it.
    held = np.concatenate(lines_below(text, "NSET, NSET=SUPPLE_CLAMPED")).astype(int) - 1
    assert len(held) == 2 * len(mesh.nodes_of("root"))
    np.testing.assert_allclose(nodes[held, 0], 0, atol=1e-15)


def test_the_load_at_an_instant_adds_up(box):
    """Gravity of a turned body, a ramp half way, and forces that turn: sums and moments by hand."""
    body = flexible_body("box", box, [RigidInterface("root", "root")])
    tip = np.asarray(box.mesh.nodes_of("tip"))
    quarter = np.array([0.0, 0.0, np.pi / 2])
    loads = [
        DeadForce(body="box", at=tip, force=Scaled([0.0, 0.0, 8.0], Ramp(1.0, 2.0))),
        DeadForce(body="box", at=tip, force=Turning([3.0, 0.0, 0.0], (0, 0, 1), lambda t: 0.5 * np.pi * t)),
    ]
    nodal = static_load(body, loads, time=1.0, rotation=quarter, gravity=(0, -9.81, 0))
    total = resultant(box, nodal)
    mass = LENGTH * 2 * (WIDTH + HEIGHT) * WALL * STEEL.density
    factor = float(Ramp(1.0, 2.0)(1.0))
    # The body's x axis points along global y: gravity runs against x, and the turned force along x.
    expected = np.array([-9.81 * mass + 3.0 * len(tip), 0.0, 8.0 * factor * len(tip)])
    np.testing.assert_allclose(total[:3], expected, atol=1e-8 * mass)
    # About the root's plane only the forces along z have an arm of the length.
    centre = box.mesh.nodes.mean(axis=0)
    assert total[4] == pytest.approx(centre[2] * expected[0] - LENGTH * expected[2], abs=1e-8 * mass)


def test_what_a_deck_cannot_hold_is_refused(box, tmp_path):
    load = np.ones((box.mesh.n_nodes, 6))
    root = box.mesh.nodes_of("root")
    with pytest.raises(ModelError, match=r"decks are \.inp files"):
        write_static_deck(tmp_path / "box.txt", box, load, root)
    with pytest.raises(ModelError, match=r"loads have shape \(3, 6\)"):
        write_static_deck(tmp_path / "box.inp", box, load[:3], root)
    with pytest.raises(ModelError, match="no node is loaded"):
        write_static_deck(tmp_path / "box.inp", box, 0 * load, root)
    with pytest.raises(ModelError, match="the load on node 0 is not finite"):
        write_static_deck(tmp_path / "box.inp", box, np.nan * load, root)
    with pytest.raises(ModelError, match="at least one"):
        write_static_deck(tmp_path / "box.inp", box, load, [])
    line = Mesh([[0, 0, 0], [1, 0, 0]], {CellType.LINE2: [[0, 1]]})
    beam = shell_model(line, BeamSection(STEEL, 1e-4, 1e-9, 1e-9, 1e-9))
    with pytest.raises(ModelError, match="beams cannot be written"):
        write_static_deck(tmp_path / "beam.inp", beam, np.ones((2, 6)), [0])
    pyramids = solid_block(1.0, 1.0, 1.0, 1, 1, 1, CellType.PYRAMID5)
    crystal = Anisotropic(STEEL.elasticity, 1.0)
    own_shear = replace(STEEL, stated_shear_modulus=1e10)
    bricks = block(1.0, 1.0, 1.0, 1, 1, 1, CellType.HEXA8)
    sheet = strip(1.0, 0.2, 4, 2)
    for model, message in (
        (solid_model(pyramids, STEEL), "PYRAMID5 cells cannot be written"),
        (solid_model(bricks, crystal), "an anisotropic material cannot be written"),
        (solid_model(bricks, own_shear), "a separate shear modulus cannot be written"),
        (shell_model(sheet, HomogeneousSection(STEEL, 0.01, offset=0.1)), "a shell section with an offset"),
    ):
        with pytest.raises(ModelError, match=message):
            write_static_deck(
                tmp_path / "odd.inp", model, np.ones((model.mesh.n_nodes, model.dofs_per_node)), [0]
            )
    A = 0.01 * STEEL.plane_stress
    laminate = LaminateSection(A, 0 * A, 1e-5 * A, 78.0, 1e-3)
    plies = shell_model(strip(1.0, 0.2, 4, 2), laminate)
    with pytest.raises(ModelError, match="a laminate cannot be written"):
        write_static_deck(tmp_path / "plies.inp", plies, np.ones((plies.mesh.n_nodes, 6)), [0])
    body = flexible_body("box", box, [RigidInterface("root", "root")])
    with pytest.raises(ModelError, match="acts on body 'bix', not on 'box'"):
        static_load(body, [DeadForce(body="bix", at=[0], force=[1.0, 0, 0])])
    springs = Attached(springs=linear_strains([(np.arange(2), np.eye(2), np.ones(2))], 6))
    with pytest.raises(ModelError, match="the springs beside the elements cannot be written"):
        write_static_deck(tmp_path / "box.inp", replace(box, attached=springs), load, root)
    for there in (
        DeadForce(body="box", at="root", force=[1.0, 0, 0]),
        FollowerForce(first="box.root", force=[1.0, 0, 0]),
    ):
        with pytest.raises(ModelError, match="acts at an interface, and a mesh has no node there"):
            static_load(body, [there])
    assert not list(tmp_path.iterdir())
