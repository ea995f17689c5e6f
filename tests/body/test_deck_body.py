"""Bodies from decks: mixed elements, masses, springs, constraints and ties within a body, beside theory."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from supple.body import (
    AveragingInterface,
    FullBody,
    MeanAxisFrame,
    RigidInterface,
    check_elements,
    deck_body,
    deck_frequencies,
    deck_mass,
    deck_mesh,
    deck_model,
    deck_models,
    deck_parts,
    inertia_gram,
    mass_of_models,
    missing_density,
    refuse_omitted_cards,
    rigid_mass_properties,
)
from supple.body.inertia_polynomial import InertiaPolynomial
from supple.body.sections import CuttingPlane, section_loads
from supple.body.tied_recovery import inner_pieces, tied_recovery, with_virtual_freedoms
from supple.body.turned_elements import turned_force
from supple.errors import ModelError, SuppleWarning
from supple.fem import stress_recovery
from supple.importers.deck import (
    BeamProperty,
    BeamValues,
    Deck,
    DeckElements,
    IsotropicMaterial,
    LeftOut,
    NodalMatrix,
    RigidTie,
    RodProperty,
    ScalarTerms,
    ShellProperty,
    SolidProperty,
    WallProperty,
    WeightedMean,
)
from supple.mesh import CellType, block
from supple.reduction import CraigBampton, NoDerivatives, NoLoads, reduce

STEEL = IsotropicMaterial(2.1e11, 0.0, 7850.0)
SIDE = 0.02
SQUARE = BeamValues(SIDE**2, SIDE**4 / 12, SIDE**4 / 12, 0.141 * SIDE**4, 0.0, 0.0, 7850.0 * SIDE**2)
EMPTY = np.empty((0, 3))


def elements(name, kind, nodes, of, first=1, directions=None):
    nodes = np.asarray(nodes)
    ids = np.arange(first, first + len(nodes))
    given = None if directions is None else np.tile(directions, (len(nodes), 1))
    return DeckElements(name, kind, nodes, ids, ids, of, given)


def beam(nodes, of="beam", first=1):
    pairs = np.column_stack([nodes[:-1], nodes[1:]])
    return elements("CBAR", CellType.LINE2, pairs, of, first, [0.0, 0.0, 1.0])


def deck(nodes, *given, **more):
    nodes = np.asarray(nodes, dtype=float)
    made_of = {
        "beam": BeamProperty(STEEL, SQUARE),
        "solid": SolidProperty(STEEL),
        "skin": ShellProperty(STEEL, 0.005),
        "rod": RodProperty(STEEL, 1e-4, 0.0, 0.785),
    }
    return Deck(Path("own.bdf"), np.arange(len(nodes)) + 1, nodes, given, made_of, **more)


def along_x(length, n, start=(0.0, 0.0, 0.0)):
    return np.column_stack([np.linspace(0, length, n + 1), np.zeros((n + 1, 2))]) + start


def point_mass(node, mass, inertia=(0.0, 0.0, 0.0)):
    return NodalMatrix(6 * node + np.arange(6), np.diag([mass] * 3 + list(inertia)))


def terms(*rows, values=(), dependent=()):
    """Rows of {6 * node + component: factor}."""
    number = np.repeat(np.arange(len(rows)), [len(row) for row in rows])
    return ScalarTerms(
        number,
        np.array([freedom for row in rows for freedom in row]),
        np.array([factor for row in rows for factor in row.values()], dtype=float),
        np.arange(len(rows)) + 100,
        np.array(values, dtype=float),
        np.array(dependent, dtype=np.int64),
    )


def frequencies(body, n, held=None):
    constraint = None if held is None else body.interface(held).motion.toarray()
    values = body.lowest_modes(n if held else n + 6, constraint).values
    return np.sqrt(values if held else values[6:]) / (2 * np.pi)


def test_a_beam_with_a_tip_mass_vibrates_as_its_closed_form():
    length, n, share = 1.0, 20, 0.7
    m = SQUARE.mass_per_length
    given = deck(along_x(length, n), beam(np.arange(n + 1)), masses=(point_mass(n, share * m * length),))
    body = deck_body("arm", given, [RigidInterface("root", [0])])
    root = brentq(
        lambda x: 1 + np.cos(x) * np.cosh(x) + share * x * (np.cos(x) * np.sinh(x) - np.sin(x) * np.cosh(x)),
        0.5,
        1.8,
    )
    exact = root**2 * np.sqrt(STEEL.youngs_modulus * SQUARE.I1 / (m * length**4)) / (2 * np.pi)
    # The slender beam of theory has no rotary inertia: (r / L)^2 = 3e-5 of its own.
    np.testing.assert_allclose(frequencies(body, 2, "root"), exact, rtol=2e-4)


def test_mass_properties_with_a_concentrated_mass_beside_its_node():
    """An offset mass with inertia: M = [m I, -m c~; m c~, J - m c~ c~]."""
    nodes, mass, offset = along_x(1.0, 4), 2.0, np.array([0.1, 0.2, -0.3])
    tilde = np.cross(offset, np.eye(3)).T
    own = np.diag([0.01, 0.02, 0.025])
    values = np.block([[mass * np.eye(3), -mass * tilde], [mass * tilde, own - mass * tilde @ tilde]])
    given = deck(nodes, beam(np.arange(5)), masses=(NodalMatrix(6 * 4 + np.arange(6), values),))
    model = deck_model(given)
    found = rigid_mass_properties(model.mass, model.mesh.nodes, 6)
    m = SQUARE.mass_per_length
    place = nodes[4] + offset
    total = m + mass
    centre = (m * np.array([0.5, 0, 0]) + mass * place) / total
    assert found.mass == pytest.approx(total)
    np.testing.assert_allclose(found.centre, centre, atol=1e-12)
    arm = place - centre
    line = np.array([0.5, 0, 0]) - centre
    inertia = own + mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    inertia += m * (line @ line * np.eye(3) - np.outer(line, line)) + np.diag([0, 1, 1]) * m / 12
    inertia += 7850.0 * SQUARE.I1 * np.diag([2, 1, 1])
    np.testing.assert_allclose(found.inertia, inertia, atol=1e-8)
    assert check_elements(model, n_frequencies=2).is_accepted


def test_a_spring_between_two_bars_moves_them_as_two_masses():
    """The nodes coincide; along the bars a soft spring, across them and in rotation they are one."""
    nodes = np.vstack([along_x(0.5, 4), along_x(0.5, 4, [0.5, 0, 0])])
    k = 1e3
    same = [{6 * 4 + c: 1.0, 6 * 5 + c: -1.0} for c in (1, 2, 3, 4, 5)]
    given = deck(
        nodes,
        beam(np.arange(5)),
        beam(np.arange(5, 10), first=10),
        springs=(terms({24: 1.0, 30: -1.0}, values=[k]),),
        constraints=(terms(*same),),
    )
    body = deck_body("bars", given, [])
    m = SQUARE.mass_per_length * 0.5
    assert frequencies(body, 1)[0] == pytest.approx(np.sqrt(2 * k / m) / (2 * np.pi), rel=1e-5)


def test_nodes_made_one_by_constraints_are_the_machine_with_one_node():
    """Also where the file's choice of dependent freedoms cannot stand, and with a row said twice."""
    nodes = np.vstack([along_x(0.5, 4), along_x(0.5, 4, [0.5, 0, 0])])
    same = [{6 * 4 + c: 1.0, 6 * 5 + c: -1.0} for c in range(6)]
    again = {24: 2.0, 30: -2.0}
    halves = (beam(np.arange(5)), beam(np.arange(5, 10), first=10))
    whole = deck_body("one", deck(along_x(1.0, 8), beam(np.arange(9))), [])
    for dependent in ([30, 31, 32, 33, 34, 35, 30], [24, 24, 24, 24, 24, 24, 24], [-1] * 7):
        given = deck(nodes, *halves, constraints=(terms(*same, again, dependent=dependent),))
        body = deck_body("two", given, [])
        assert body.n == whole.n
        np.testing.assert_allclose(frequencies(body, 5), frequencies(whole, 5), rtol=1e-8)


def test_a_constraint_to_ground_is_refused_with_its_line():
    given = deck(along_x(1.0, 2), beam(np.arange(3)), constraints=(terms({6: 1.0}),))
    with pytest.raises(ModelError, match=r"own.bdf, line 100: the constraint .*resists rigid motion"):
        deck_body("arm", given, [])


def skinned(constraints=(), **more):
    """A block of solids with shells on the nodes of its faces y = +- 0.05, all along x."""
    mesh = block(1.0, 0.1, 0.1, 8, 1, 1, CellType.HEXA8)
    cells = mesh.cells[CellType.HEXA8]
    quads = []
    for sign in (-1, 1):
        for cell in cells:
            own = cell[mesh.nodes[cell, 1] * sign > 0]
            x, z = mesh.nodes[own, 0], mesh.nodes[own, 2]
            order = np.argsort(np.arctan2(z - z.mean(), x - x.mean()))
            quads.append(own[order])
    triangles = np.array([q[[0, 1, 2]] for q in quads] + [q[[0, 2, 3]] for q in quads])
    return deck(
        mesh.nodes,
        elements("CHEXA", CellType.HEXA8, cells, "solid"),
        elements("CTRIA3", CellType.TRIANGLE3, triangles, "skin", 100),
        node_sets=dict(mesh.node_sets),
        **more,
    )


def test_a_skin_on_a_solid_adds_its_stiffness_and_mass():
    """Uniform stretching, without a Poisson effect: U = 1/2 E (A + 2 b t) eps^2 L."""
    given = skinned()
    model = deck_model(given)
    area, eps = 0.1 * 0.1 + 2 * 0.1 * 0.005, 1e-3
    u = np.zeros((model.mesh.n_nodes, 6))
    u[:, 0] = eps * model.mesh.nodes[:, 0]
    q = u.ravel()
    assert q @ (model.stiffness @ q) == pytest.approx(STEEL.youngs_modulus * area * eps**2, rel=1e-9)
    body = deck_body("panel", given, [RigidInterface("root", "root")])
    assert rigid_mass_properties(body.nodal_mass, body.nodes, 6).mass == pytest.approx(7850 * area)
    exact = np.sqrt(STEEL.youngs_modulus / STEEL.density) / 4
    assert np.abs(frequencies(body, 12, "root") / exact - 1).min() < 2e-3
    assert check_elements(model, n_frequencies=2).is_accepted


def test_solids_beside_shells_keep_their_derivatives():
    """The tangent is the derivative of the force, of a body of both kinds with a tie and a spring inside."""
    given = skinned(
        rigid=(RigidTie("rbe2_1", 0, np.array([1, 2, 3]), 1),),
        springs=(terms({6 * 20: 1.0, 6 * 24: -1.0}, values=[0.0]),),
    )
    body = deck_body("panel", given, [RigidInterface("tip", "tip")])
    rng = np.random.default_rng(1)
    q, v = 1e-3 * rng.normal(size=(2, body.n))
    step = 1e-20
    along = body.assembly.internal_force(q + 1j * step * v).imag / step
    np.testing.assert_allclose(body.assembly.tangent(q) @ v, along, atol=1e-9 * np.abs(along).max())
    np.testing.assert_allclose(body.assembly.tangent(0 * q) @ v, body.stiffness @ v, rtol=1e-6, atol=1e-3)


def solid_bar(**more):
    mesh = block(1.0, 0.1, 0.1, 6, 1, 1, CellType.HEXA8)
    cells = elements("CHEXA", CellType.HEXA8, mesh.cells[CellType.HEXA8], "solid")
    nodes = np.vstack([mesh.nodes, [0.5, 0.3, 0.0]])
    return deck(nodes, cells, node_sets=dict(mesh.node_sets), **more)


def middle(given):
    return np.flatnonzero(np.abs(given.nodes[:, 0] - 0.5) < 1e-9)


def test_a_rigid_tie_within_a_body_does_not_strain_it_where_it_turns():
    """Where it stands as the elements beside it want it, |theta| = tan phi, the energy is of order phi^8."""
    bare = solid_bar()
    own = middle(bare)
    given = replace(bare, rigid=(RigidTie("rbe2_7", int(own[-1]), own[:-1], 7),))
    body = deck_body("bar", given, [])
    assert body.dofs_per_node == 3
    energies = []
    for phi in (0.05, 0.1):
        turn = np.array([[1, 0, 0], [0, np.cos(phi), -np.sin(phi)], [0, np.sin(phi), np.cos(phi)]])
        free = np.setdiff1d(np.arange(len(given.nodes)), own)
        at = given.nodes[own[-1]]
        q = np.concatenate(
            [(given.nodes[free] @ (turn - np.eye(3)).T).ravel(), (turn - np.eye(3)) @ at, [np.tan(phi), 0, 0]]
        )
        energies.append(body.force.energies(q[:, None])[0])
    linear = 0.5 * q @ (body.stiffness @ q)
    assert energies[1] / energies[0] == pytest.approx(256, rel=0.1)
    assert energies[1] < 1e-3 * linear


def test_ties_that_share_nodes_are_one_piece_and_an_interface_may_take_it():
    bare = solid_bar()
    own = middle(bare)
    ties = (RigidTie("rbe2_1", int(own[-1]), own[:2], 1), RigidTie("rbe2_2", int(own[0]), own[2:4], 2))
    one = (RigidTie("rbe2_1", int(own[-1]), own[:-1], 1),)
    chain = deck_body("bar", replace(bare, rigid=ties), [])
    whole = deck_body("bar", replace(bare, rigid=one), [])
    np.testing.assert_allclose(frequencies(chain, 4), frequencies(whole, 4), rtol=1e-8)
    body = deck_body("bar", replace(bare, rigid=one))
    np.testing.assert_allclose(frequencies(body, 4), frequencies(whole, 4), rtol=1e-8)
    hub = body.interface("rbe2_1")
    np.testing.assert_allclose(hub.position, [0.5, 0.3, 0.0])
    assert set(hub.tied_nodes) == set(own)
    np.testing.assert_allclose(hub.motion @ body.rigid_modes[:, :3], np.vstack([np.eye(3), np.zeros((3, 3))]))
    with pytest.raises(ModelError, match="join the interfaces 'a' and 'b'"):
        deck_body(
            "bar", replace(bare, rigid=ties), [RigidInterface("a", own[:1]), RigidInterface("b", own[2:3])]
        )


def test_a_mass_on_a_weighted_mean_takes_the_nodes_along():
    """An RBE3 adds no stiffness, and R^T M R is that of bar and mass."""
    bare = solid_bar()
    own = middle(bare)
    mean = WeightedMean("rbe3_4", int(own[-1]), own[:-1], np.ones(len(own) - 1), 4)
    given = replace(bare, means=(mean,), masses=(point_mass(int(own[-1]), 3.0, (0.1, 0.1, 0.1)),))
    body = deck_body("bar", given, [])
    own_mass = 7850 * 0.01
    R, M = body.rigid_modes, body.mass
    assert R[:, 0] @ (M @ R[:, 0]) == pytest.approx(own_mass + 3.0)
    # About x through the origin: bar, mass at y = 0.3, own inertia.
    turned = own_mass * (0.1**2 + 0.1**2) / 12 + 3.0 * 0.3**2 + 0.1
    assert R[:, 3] @ (M @ R[:, 3]) == pytest.approx(turned, rel=1e-6)
    np.testing.assert_allclose(body.stiffness @ R, 0, atol=1e-3)


def test_a_mean_turns_what_is_rigidly_tied_to_its_reference():
    """Two bars of solids, a tie of one and a mean of the other at one node: joined, also about all axes."""
    bare = solid_bar()
    n = len(bare.nodes)
    (cells,) = bare.elements
    both = replace(
        bare,
        nodes=np.vstack([bare.nodes, bare.nodes + np.array([0.0, 0.0, 2.0])]),
        node_ids=np.arange(2 * n) + 1,
        elements=(cells, replace(cells, nodes=cells.nodes + n, ids=cells.ids + 100)),
    )
    own = middle(bare)
    tie = RigidTie("rbe2_1", int(own[-1]), own[:-1], 1)
    mean = WeightedMean("rbe3_2", int(own[-1]), n + own[:-1], np.ones(len(own) - 1), 2)
    body = deck_body("two", replace(both, rigid=(tie,), means=(mean,)), [])
    values = body.lowest_modes(7).values
    assert values[6] > 1e6 * max(abs(values[5]), 1.0)
    # Both as interfaces have one motion.
    body = deck_body("two", replace(both, rigid=(tie,), means=(mean,)))
    reduced = reduce(body.linearized(), MeanAxisFrame(), CraigBampton(2), derivatives=NoDerivatives())
    tied, mean_motion = (reduced.interface(name).motion for name in ("rbe2_1", "rbe3_2"))
    np.testing.assert_allclose(mean_motion, tied, atol=1e-9 * np.abs(tied).max())


def test_rotations_that_only_a_spring_joins_are_named():
    """A spring between the rotations of two nodes of solids, which nothing else holds."""
    bar = solid_bar()
    a, b = middle(bar)[:2]
    spring = terms({6 * int(a) + 3: 1.0, 6 * int(b) + 3: -1.0}, values=[10.0])
    with pytest.raises(ModelError, match=rf"such as rx of the node at \({bar.nodes[[a, b], 0].max():g}"):
        deck_body("bar", replace(bar, springs=(spring,)), [])


def test_rods_and_nodes_that_nothing_turns():
    """A tetrahedron of rods: no node has a stiff rotation, 12 freedoms are left."""
    nodes = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
    pairs = np.array([[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]])
    body = deck_body("truss", deck(nodes, elements("CROD", CellType.LINE2, pairs, "rod")), [])
    assert body.n == 12
    assert (frequencies(body, 6) > 0).all()


def test_parts_are_named_and_nodes_without_use_left_out():
    nodes = np.vstack([along_x(1.0, 4), along_x(1.0, 2, [0, 1, 0]), [[9.0, 9.0, 9.0]]])
    given = deck(nodes, beam(np.arange(5)), beam(np.arange(5, 8), first=10), masses=(point_mass(7, 1.0),))
    assert {name: len(part.node_ids) for name, part in deck_parts(given).items()} == {
        "part_1": 5,
        "part_2": 3,
    }
    with pytest.raises(ModelError, match=r"2 disconnected parts: part_1 \(5 nodes\), part_2 \(3"):
        deck_body("both", given, [])
    body = deck_body("short", given, [], part="part_2")
    assert rigid_mass_properties(body.nodal_mass, body.nodes, 6).mass == pytest.approx(
        1 + SQUARE.mass_per_length
    )
    with pytest.raises(ModelError, match="it has no part 'part_3'"):
        deck_body("none", given, [], part="part_3")


def test_a_node_without_cells_stays_in_the_mesh():
    bare = solid_bar()
    own = middle(bare)
    mesh = deck_mesh(replace(bare, rigid=(RigidTie("rbe2_7", int(own[-1]), own[:-1], 7),)))
    assert mesh.n_nodes == len(bare.nodes)
    assert "rbe2_7" in mesh.node_sets


def test_a_dashpot_damps_the_motion_between_its_ends():
    """Two masses m on a light bar of stiffness k, with a dashpot c: damping ratio  c / (m omega), 2 k / m."""
    nodes, m, c = along_x(1.0, 2), 1e4, 2e5
    masses = (point_mass(0, m, (1.0, 1.0, 1.0)), point_mass(2, m, (1.0, 1.0, 1.0)))
    between = terms({0: 1.0, 12: -1.0}, values=[c])
    body = deck_body("bar", deck(nodes, beam(np.arange(3)), masses=masses, dashpots=(between,)), [])
    omega = np.sqrt(2 * STEEL.youngs_modulus * SQUARE.area / m)
    M, C, K = (matrix.toarray() for matrix in (body.mass, body.damping, body.stiffness))
    n = len(M)
    first_order = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    ratio = c / (m * omega)
    axial = omega * (-ratio + 1j * np.sqrt(1 - ratio**2))
    assert np.abs(np.linalg.eigvals(first_order) - axial).min() < 2e-3 * omega
    across = replace(between, freedoms=np.array([1, 13]))
    with pytest.raises(ModelError, match=r"line 100: a spring or dashpot .* resists rigid motion"):
        deck_body("bar", deck(nodes, beam(np.arange(3)), masses=masses, dashpots=(across,)), [])


def test_a_damping_matrix_on_rotations_that_nodes_of_solids_do_not_have():
    """Its rows of translations act, and no row acts on another node."""
    pair = np.array([[1.0, -1.0], [-1.0, 1.0]])
    ends = np.array([0, 6 * 12])  # two nodes on one line along x
    alone = NodalMatrix(ends, 3.0 * pair)
    both = NodalMatrix(np.concatenate([ends, ends + 3]), np.kron(np.diag([3.0, 5.0]), pair))
    C = [deck_body("bar", solid_bar(dampings=(each,)), []).damping.toarray() for each in (alone, both)]
    assert C[0].any()
    np.testing.assert_array_equal(C[1], C[0])


def test_springs_to_ground_and_springs_across_are_named():
    nodes = along_x(1.0, 2)
    ground = deck(nodes, beam(np.arange(3)), springs=(terms({0: 1.0}, values=[1e3]),))
    with pytest.warns(SuppleWarning, match="1 springs or dashpots to ground, first on line 100"):
        deck_model(ground)
    across = deck(nodes, beam(np.arange(3)), springs=(terms({1: 1.0, 13: -1.0}, values=[1e3]),))
    with pytest.raises(ModelError, match=r"line 100: a spring .* resists rigid motion"):
        deck_model(across)


def test_what_is_left_out_stops_unless_allowed():
    given = deck(along_x(1.0, 2), beam(np.arange(3)), left_out=(LeftOut("CGAP", 2, 17, "a gap"),))
    with pytest.raises(ModelError, match=r'2 CGAP \(first on line 17\): a gap.*leave_out = \["CGAP"\]'):
        refuse_omitted_cards(given)
    refuse_omitted_cards(given, ["CGAP"])


def test_without_density_the_remedy_is_said():
    light = SolidProperty(replace(STEEL, density=0.0))
    given = replace(solid_bar(), properties={"solid": light})
    with pytest.raises(ModelError, match="freedoms have no mass; give its materials a density"):
        deck_body("bar", deck_parts(given)[""], [])


def test_solids_and_shells_without_density_beside_others_are_warned_of():
    light = SolidProperty(replace(STEEL, density=0.0))
    given = skinned()
    given = replace(given, properties={**given.properties, "solid": light})
    with pytest.warns(SuppleWarning, match=r"8 solids or shells lack mass.* no density: solid \(8\)"):
        model = deck_model(given)
    assert mass_of_models([model]).mass == pytest.approx(2 * 0.1 * 0.005 * 7850.0)
    wall = WallProperty(1e7 * np.eye(3), np.zeros((3, 3)), 1e2 * np.eye(3), None, 10.0, 1e-3, 0.01)
    properties = {**skinned().properties, "skin": replace(wall, lacks_density=True)}
    assert "32 solids or shells lack mass" in missing_density(replace(given, properties=properties))
    assert not missing_density(replace(given, properties={**properties, "skin": wall}))


def test_averaging_nodes_on_a_line_of_solids_is_refused():
    given = skinned()
    line = np.flatnonzero((given.nodes[:, 0] == 0) & (given.nodes[:, 1] < 0))
    deck_body("panel", given, [AveragingInterface("edge", line)])
    core = replace(given, elements=given.elements[:1], masses=(point_mass(0, 1.0, (1.0, 1.0, 1.0)),))
    with pytest.raises(ModelError, match="some are of solids, which have no rotations"):
        deck_body("core", core, [AveragingInterface("edge", line)])


def test_frequencies_of_all_parts_free_and_at_the_supports_of_the_deck():
    """Cantilever and free-free beam of Euler and Bernoulli, (beta L)^2 = 3.516, 22.034; and 22.373."""
    n, length = 40, 1.0
    nodes = np.vstack([along_x(length, n), along_x(length, n, [0, 1, 0])])
    clamped = terms(*({c: 1.0} for c in range(6)))
    given = deck(nodes, beam(np.arange(n + 1)), beam(np.arange(n + 1, 2 * n + 2), first=500), held=(clamped,))
    unit = np.sqrt(STEEL.youngs_modulus * SQUARE.I1 / SQUARE.mass_per_length) / (2 * np.pi)
    free = deck_frequencies(given, 4)
    np.testing.assert_allclose(free, 22.3733 * unit, rtol=1e-3)
    held = deck_frequencies(given, 10, held=True)
    np.testing.assert_allclose(held[:6], 0, atol=1e-2)
    np.testing.assert_allclose(held[6:8], 3.51602 * unit, rtol=5e-4)
    np.testing.assert_allclose(held[8:], 22.0345 * unit, rtol=1e-3)
    together = mass_of_models(list(deck_models(given).values()))
    assert together.mass == pytest.approx(2 * SQUARE.mass_per_length)
    np.testing.assert_allclose(together.centre, [0.5, 0.5, 0.0], atol=1e-9)


@pytest.mark.parametrize("kind", ["rigid", "means"])
def test_a_tie_of_solids_held_in_all_six_is_clamped(kind):
    """Fixed translations and rotations of the reference node of a tie are those of the tied nodes."""
    bare = solid_bar()
    end = np.flatnonzero(bare.nodes[:, 0] == 0)
    centre = len(bare.nodes) - 1
    nodes = np.vstack([bare.nodes[:-1], bare.nodes[end].mean(axis=0)])
    tie = {
        "rigid": (RigidTie("rbe2_1", centre, end, 1),),
        "means": (WeightedMean("rbe3_1", centre, end, np.ones(len(end)), 1),),
    }[kind]
    held = (terms(*({6 * centre + c: 1.0} for c in range(6))),)
    tied = deck_frequencies(replace(bare, nodes=nodes, held=held, **{kind: tie}), 4, held=True)
    held = (terms(*({6 * node + c: 1.0} for node in end for c in range(3))),)
    clamped = deck_frequencies(replace(bare, nodes=nodes, held=held), 4, held=True)
    np.testing.assert_allclose(tied, clamped, rtol=1e-9 if kind == "rigid" else 0.05)


def test_the_inertia_of_a_body_with_constraints_is_that_of_the_body_without():
    """Coordinates of two halves joined by constraints stand no longer in threes; the inertia is the same."""
    nodes = np.vstack([along_x(0.5, 3), along_x(0.5, 3, [0.5, 0, 0])])
    same = [{6 * 3 + c: 1.0, 6 * 4 + c: -1.0} for c in range(6)]
    parts = (beam(np.arange(4)), beam(np.arange(4, 8), first=10))
    joined = terms(*same, dependent=[18, 25, 20, 27, 22, 29])
    beside = (point_mass(5, 2.0, (0.1, 0.2, 0.25)),)
    two = deck_body("two", deck(nodes, *parts, constraints=(joined,), masses=beside), [])
    beside = (point_mass(4, 2.0, (0.1, 0.2, 0.25)),)
    one = deck_body("one", deck(along_x(1.0, 6), beam(np.arange(7)), masses=beside), [])
    V = np.random.default_rng(3).normal(size=(one.n, 3))
    fields = (one.expansion @ V).reshape(7, 6, 3)[[0, 1, 2, 3, 3, 4, 5, 6]].reshape(-1, 3)
    own, *_ = np.linalg.lstsq(two.expansion.toarray(), fields, rcond=None)
    np.testing.assert_allclose(two.expansion @ own, fields, atol=1e-12)
    np.testing.assert_allclose(inertia_gram(two, own), inertia_gram(one, V), atol=1e-10)
    spins = InertiaPolynomial(two).by_spin[3]
    np.testing.assert_allclose(
        own.T @ (spins @ own), V.T @ (InertiaPolynomial(one).by_spin[3] @ V), atol=1e-10
    )


def test_lines_take_the_moduli_that_a_deck_states():
    """E and G alone, also where no Poisson's ratio of a solid gives G, or where there is none to twist."""
    stiff = replace(SQUARE, J=2e-8)
    for G, ratio in ((1e9, 104.0), (0.0, 0.3)):
        made_of = BeamProperty(IsotropicMaterial(2.1e11, ratio, 7850.0, G), stiff)
        given = replace(deck(along_x(1.0, 1), beam(np.arange(2))), properties={"beam": made_of})
        K = deck_model(given).stiffness.toarray()
        assert K[9, 9] == pytest.approx(G * 2e-8, abs=1e-6)
        assert K[6, 6] == pytest.approx(2.1e11 * SQUARE.area)


def test_scalar_points_vibrate_at_the_supports_and_are_no_part_of_a_body():
    """A mass of one freedom on a spring from a clamped bar: omega^2 = k / m; a free body is without both."""
    bar = deck(along_x(1.0, 4), beam(np.arange(5)), held=(terms(*({c: 1.0} for c in range(6))),))
    given = replace(
        bar,
        scalar_points=np.array([77]),
        springs=(terms({6 * 4: 1.0, 6 * 5: -1.0}, values=[1e3]),),
        inertias=(terms({6 * 5: 1.0}, values=[0.5]),),
    )
    soft = deck_frequencies(given, 3, held=True)
    assert soft[0] == pytest.approx(np.sqrt(1e3 / 0.5) / (2 * np.pi), rel=1e-4)
    np.testing.assert_allclose(deck_frequencies(given, 3), deck_frequencies(bar, 3), rtol=1e-9)
    assert deck_mass(given).mass == pytest.approx(SQUARE.mass_per_length)
    with pytest.warns(SuppleWarning, match="2 springs, .* on scalar points, first on line 100, are omitted"):
        assert deck_model(given).mesh.n_nodes == 5
    with pytest.warns(SuppleWarning, match="2 springs, .* on scalar points"):
        deck_body("bar", given, [RigidInterface("root", [0])])
    # A scalar point that only records a motion, and one that no node moves, have no effect.
    recorded = replace(
        bar, scalar_points=np.array([77]), constraints=(terms({6 * 5: 1.0, 6 * 4: -1.0}, dependent=[6 * 5]),)
    )
    alone = replace(given, springs=(terms({6 * 5: 1.0}, values=[1e3]),))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert [deck_model(each).attached.constraints for each in (recorded, alone)] == [None, None]


def test_the_direction_of_a_wall_that_is_normal_to_it_is_replaced():
    wall = WallProperty(1e7 * np.eye(3), np.zeros((3, 3)), 1e2 * np.eye(3), None, 10.0, 1e-3, 0.01)
    triangles = elements("CTRIA3", CellType.TRIANGLE3, [[0, 1, 2], [0, 2, 3]], "wall", 1, [0.0, 0.0, 1.0])
    square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    given = replace(deck(square, triangles), properties={"wall": wall})
    with pytest.warns(SuppleWarning, match=r"line 1: the material direction of .* \(one of 2\) is normal"):
        deck_model(given)


def test_stress_of_solids_and_shells_in_one_body():
    """Uniform stretching: E eps in every layer at every node."""
    model = deck_model(skinned())
    u = np.zeros((model.mesh.n_nodes, 6))
    u[:, 0] = 1e-6 * model.mesh.nodes[:, 0]
    stress = stress_recovery(model).linearized().at_nodes(u.ravel())
    assert stress.shape == (model.mesh.n_nodes, 3, 6)
    np.testing.assert_allclose(stress[..., 0], STEEL.youngs_modulus * 1e-6, rtol=1e-9)
    np.testing.assert_allclose(stress[..., 1:], 0, atol=1e-3)


def test_a_body_with_ties_masses_and_a_rotation_that_rests_is_reduced():
    """Its kinetic energy of rigid motion stays; the lowest modes are those of the whole."""
    given = skinned(
        rigid=(RigidTie("rbe2_1", 0, np.array([1, 2, 3]), 1),),
        masses=(point_mass(12, 0.5, (0.01, 0.01, 0.01)),),
    )
    body = deck_body("panel", given, [RigidInterface("tip", "tip")])
    small = reduce(
        body, MeanAxisFrame(), CraigBampton(n_modes=10), derivatives=NoDerivatives(), loads=NoLoads
    )
    R = body.rigid_modes
    np.testing.assert_allclose(small.gram[:6, :6], R.T @ (body.mass @ R), rtol=1e-9, atol=1e-9)
    own = np.sort(frequencies(body, 3))
    free = body.lowest_modes(9).values[6:]
    np.testing.assert_allclose(own, np.sqrt(free) / (2 * np.pi))
    assert small.frequencies[0] / (2 * np.pi) == pytest.approx(own[0], rel=1e-3)


def test_stress_beside_a_tie_that_turns_is_none():
    """As of energies: at |theta| = tan phi the stress is of order phi^4; without second order of phi^2."""
    bare = solid_bar()
    own = middle(bare)
    given = replace(bare, rigid=(RigidTie("rbe2_7", int(own[-1]), own[:-1], 7),))
    body = deck_body("bar", given, [])
    phi = 0.1
    turn = Rotation.from_rotvec([phi, 0, 0]).as_matrix() - np.eye(3)
    free = np.setdiff1d(np.arange(len(given.nodes)), own)
    place = turn @ given.nodes[own[-1]]
    q = np.concatenate([(given.nodes[free] @ turn.T).ravel(), place, [np.tan(phi), 0, 0]])
    recovery = stress_recovery(body.model)
    nodal = body.expansion @ q
    linear = np.abs(recovery.at_nodes(nodal)).max()
    inner = inner_pieces(recovery.pieces, body.nodes, 3, body.interfaces)
    fields = with_virtual_freedoms(
        nodal[:, None], [piece.motion @ nodal[:, None] for piece in inner], inner, 3
    )
    tied = tied_recovery(recovery, body.nodes, 3, inner)
    assert np.abs(tied.at_nodes(fields[:, 0])).max() < 0.02 * linear
    # Elements that turn exactly have no force, where the rotation vector is that of phi to the last digit.
    q[-3] = brentq(lambda theta: theta * (1 - theta**2 / 3) - phi, 0.0, 0.2, xtol=1e-15)
    assert np.abs(turned_force(body, q)).max() < 1e-9 * np.abs(body.stiffness @ q).max()


def test_a_section_beside_a_tie_is_refused():
    bare = solid_bar()
    own = middle(bare)
    body = deck_body("bar", replace(bare, rigid=(RigidTie("rbe2_7", int(own[-1]), own[:-1], 7),)), [])
    full = FullBody(body, MeanAxisFrame())
    plane = CuttingPlane((0.5, 0.0, 0.0), (1.0, 0.0, 0.0))
    with pytest.raises(ModelError, match="is at the rigid tie 'rbe2_7'"):
        section_loads(full, body.model, SimpleNamespace(coordinates=np.zeros((1, body.n))), plane)


def test_a_deck_that_lumps_its_beams_vibrates_as_masses_on_springs():
    """One element from a support: omega^2 = (E A / L) / (m L / 2); the consistent mass has m L / 3."""
    clamped = terms(*({c: 1.0} for c in (*range(6), 7, 8, 9, 10, 11)))
    given = deck(along_x(1.0, 1), beam(np.arange(2)), held=(clamped,))
    unit = np.sqrt(STEEL.youngs_modulus / STEEL.density) / (2 * np.pi)
    for lumps, factor in ((True, 2.0), (False, 3.0)):
        found = deck_frequencies(replace(given, lumped_mass=lumps), 1, held=True)
        assert found[0] == pytest.approx(np.sqrt(factor) * unit)
