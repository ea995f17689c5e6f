"""Bodies from bulk data: the same matrices as our own path, closed forms, and our own interfaces."""

from __future__ import annotations

import numpy as np
import pytest

from supple.algebra import lowest_modes
from supple.body import (
    AveragingInterface,
    NodalFixedFrame,
    RigidInterface,
    Verdict,
    check_elements,
    connection_named,
    deck_body,
    deck_connections,
    deck_model,
    deck_parts,
)
from supple.errors import ModelError
from supple.fem import VON_KARMAN, HomogeneousSection, Isotropic, shell_model, solid_model
from supple.importers import read_deck
from supple.mesh import CellType, block, strip

STEEL = Isotropic(2.1e11, 0.3, 7850.0)
LENGTH, WIDTH, THICKNESS = 1.0, 0.1, 0.01


@pytest.fixture
def write(tmp_path):
    def write_text(text):
        path = tmp_path / "model.bdf"
        path.write_text(text)
        return path

    return write_text


def model_of(path, **options):
    (part,) = deck_parts(read_deck(path)).values()
    return deck_model(part, **options)


def body_of(name, path):
    return deck_body(name, read_deck(path))


@pytest.mark.parametrize("kind", [CellType.TETRA4, CellType.TETRA10, CellType.HEXA20])
def test_a_block_has_the_matrices_and_frequencies_of_our_own_path(write, bulk, kind):
    mesh = block(1.0, 0.3, 0.2, 4, 2, 2, kind)
    model = model_of(write(bulk.text(mesh, *bulk.solid(), "PARAM,COUPMASS,1")))
    own = solid_model(mesh, STEEL)
    assert abs(model.stiffness - own.stiffness).max() == 0
    assert abs(model.mass - own.mass).max() == 0
    modes = [lowest_modes(m.stiffness, m.mass, 9).values[6:] for m in (model, own)]
    np.testing.assert_array_equal(*modes)


def test_shells_take_their_walls_and_kinematics(write, bulk):
    mesh = strip(2.0, 0.4, 8, 2)
    path = write(bulk.text(mesh, *bulk.shell(0.02)))
    for options in ({}, {"kinematics": VON_KARMAN}):
        model, own = (
            model_of(path, **options),
            shell_model(mesh, HomogeneousSection(STEEL, 0.02), **options),
        )
        assert abs(model.stiffness - own.stiffness).max() == 0
        assert model.blocks[0].N.shape == own.blocks[0].N.shape


def quadrilaterals(bulk, n_length, n_width):
    """A strip of CQUAD4 along x, its root tied to grid 9001 by an RBE2 and its tip to 9002 by an RBE3."""
    x, y = np.linspace(0, LENGTH, n_length + 1), np.linspace(-WIDTH / 2, WIDTH / 2, n_width + 1)
    nodes = np.array([[a, b, 0.0] for a in x for b in y])
    number = np.arange(1, len(nodes) + 1).reshape(n_length + 1, n_width + 1)
    corners = zip(
        number[:-1, :-1].ravel(),
        number[1:, :-1].ravel(),
        number[1:, 1:].ravel(),
        number[:-1, 1:].ravel(),
        strict=True,
    )
    cards = bulk.grids(nodes)
    cards += [bulk.card("CQUAD4", i, 1, *quad) for i, quad in enumerate(corners, 1)]
    cards += ["GRID,9001,,-.05,0.,0.", f"GRID,9002,,{LENGTH},0.,0."]
    cards += [bulk.card("RBE2", 501, 9001, 123456, *number[0])]
    cards += [bulk.card("RBE3", 502, None, 9002, 123456, 1.0, 123, *number[-1])]
    return bulk.deck(*cards, *bulk.shell(THICKNESS)), number[0] - 1, number[-1] - 1


def test_a_cantilever_of_cquad4_has_the_frequencies_of_a_beam(write, bulk):
    """omega = (beta L)^2 sqrt(E I / (rho A L^4)), Euler-Bernoulli; a strip without Poisson coupling."""
    text, _, _ = quadrilaterals(bulk, 40, 4)
    body = body_of("strip", write(text.replace(",0.3,7850.0", ",0.0,7850.0")))
    D = NodalFixedFrame("rbe2_501").constraint(body)
    omega = np.sqrt(lowest_modes(body.stiffness, body.mass, 5, constraint=D).values)
    unit = np.sqrt(2.1e11 * THICKNESS**2 / 12 / 7850.0) / LENGTH**2
    expected = unit * np.array([1.8751041, 4.6940911, 7.8547574]) ** 2
    found = [omega[np.argmin(abs(omega - value))] for value in expected]
    np.testing.assert_allclose(found, expected, rtol=5e-3)


def test_connections_are_our_interfaces(write, bulk):
    text, root, tip = quadrilaterals(bulk, 6, 2)
    path = write(text)
    body = body_of("strip", path)
    own = deck_body(
        "strip",
        read_deck(path),
        [
            RigidInterface("rbe2_501", root, (-0.05, 0, 0)),
            AveragingInterface("rbe3_502", tip, (LENGTH, 0, 0)),
        ],
    )
    assert abs(body.stiffness - own.stiffness).max() == 0
    for made, expected in zip(body.interfaces, own.interfaces, strict=True):
        assert made.name == expected.name
        np.testing.assert_array_equal(made.position, expected.position)
        assert abs(made.motion - expected.motion).max() == 0


def test_an_averaging_connection_follows_its_weights(write, bulk):
    """Two nodes pull three times as much as the other: the mean of u is weighted so."""
    mesh = block(1.0, 1.0, 1.0, 1, 1, 1, CellType.HEXA8)
    cards = ["GRID,900,,0.,0.,0.", "RBE3,7,,900,123456,1.0,123,1,2", ",3.0,123,3,4"]
    body = body_of("cube", write(bulk.text(mesh, *bulk.solid(), *cards)))
    motion = body.interface("rbe3_7").motion.toarray()
    position = body.interface("rbe3_7").position
    at_centroid = motion[:3] - np.cross(motion[3:].T, position - mesh.nodes[:4].T @ [1, 1, 3, 3] / 8).T
    np.testing.assert_allclose(at_centroid[0, [0, 3, 6, 9]], np.array([1, 1, 3, 3]) / 8, atol=1e-12)


def test_a_frame_of_beams_has_the_stiffness_of_its_members(write, bulk):
    """A cantilever of CBEAM along y: P L^3 / 3 E I + P L / (K G A) at its tip, in both planes."""
    cards = bulk.grids(np.linspace(0, 2, 5)[:, None] * [0, 1.0, 0])
    cards += [bulk.card("CBEAM", i, 1, i, i + 1, 0.0, 0.0, 1.0) for i in range(1, 5)]
    properties = "PBEAM,1,5,.01,2.-5,1.-5,0.,3.-5", ",", ",.5,.8"
    model = model_of(write(bulk.deck(*cards, *properties, bulk.steel())))
    flexibility = np.linalg.inv(model.stiffness.toarray()[6:, 6:])[-6:, -6:]
    G = STEEL.shear_modulus
    for axis, moment, factor in ((2, 2e-5, 0.5), (0, 1e-5, 0.8)):
        expected = 8 / (3 * 2.1e11 * moment) + 2 / (factor * G * 0.01)
        assert flexibility[axis, axis] == pytest.approx(expected, rel=1e-9)


MOUNTS = """\
GRID,1,,0.,0.,0.
GRID,2,,1.,0.,0.
GRID,3,,1.,0.,0.
GRID,4,,-1.,0.,0.
GRID,5,,-1.,0.,0.
CONM2,10,1,,20.,,,,,+
+,2.,,2.,,,2.
PBUSH,7,K,2.E4,3.E4,4.E4,50.,50.,50.
CBUSH,21,7,2,3,,,,0
CBUSH,22,7,4,5,,,,0
"""


def test_a_mass_on_mounts_has_no_waves_and_is_a_rigid_body(write):
    """Grids 3 and 5 of the mounts have no mass: in free motion nothing is strained."""
    path = write(MOUNTS + "RBE2,31,1,123456,2,4\n")
    check = check_elements(model_of(path))
    found = {each.what: each for each in check.findings}
    assert found["units"].verdict is Verdict.OK
    assert "elements of the machine" in found["lowest modes"].remedy
    with pytest.raises(ModelError, match="no motion strains it: use a rigid body"):
        body_of("engine", path)
    path = write(MOUNTS + "CONM2,11,3,,5.,,,,,+\n+,.1,,.1,,,.1\nRBE2,31,1,123456,2,4\n")
    found = check_elements(model_of(path))
    assert found.is_accepted
    along = 2e4 / (20.0 * 5.0 / 25.0)  # both masses on the spring along x
    squares = (2 * np.pi * np.array(found.frequencies)) ** 2
    assert min(abs(squares - along)) < 1e-6 * along


def test_a_rigid_interface_at_a_node_without_mass_names_the_node(write):
    text = MOUNTS + "MAT1,1,2.1E11,,.3,7850.\nPBAR,1,1,1.E-3,1.E-6,1.E-6,2.E-6\n"
    path = write(text + "CBAR,1,1,1,2,0.,0.,1.\nCBAR,2,1,1,4,0.,0.,1.\n")
    (part,) = deck_parts(read_deck(path)).values()
    with pytest.raises(ModelError, match=r"node 3 ux has the mass .*an interface beyond it"):
        deck_body("engine", part, [RigidInterface("mount", [2])])


def test_an_unknown_connection_lists_those_there_are(write, bulk):
    text, _, _ = quadrilaterals(bulk, 2, 1)
    connections = deck_connections(read_deck(write(text)))
    assert connection_named("rbe2_501", connections).weights is None
    with pytest.raises(ModelError, match=r"no connection 'rbe2_1'.*it has 'rbe2_501', 'rbe3_502'"):
        connection_named("rbe2_1", connections)
