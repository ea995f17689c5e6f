"""From elements to a line: exact moments of inertia, frequencies of the mesh, stations that are refused."""

import numpy as np
import pytest

from supple.algebra import lowest_modes
from supple.body import AveragingInterface, RigidInterface, flexible_body
from supple.body.rigid_motion import nodal_rigid_modes
from supple.errors import ModelError
from supple.fem import BeamSection, HomogeneousSection, Isotropic, shell_model, solid_model
from supple.mesh import CellType, Mesh, strip
from supple.mesh.cuboids import block
from supple.methods.intrinsic import CLAMPED, FREE, LoadPath, LoadPaths, NodeSetPath, condense
from supple.methods.intrinsic.intrinsic_motion import IntrinsicMotion

STEEL = Isotropic(2.1e11, 0.3, 7850.0)


@pytest.fixture(scope="module")
def shell_strip():
    model = shell_model(strip(1.0, 0.05, 24, 2), HomogeneousSection(STEEL, 0.004))
    return flexible_body(
        "strip",
        model,
        [
            RigidInterface("root", "root"),
            AveragingInterface("tip", "tip"),
            AveragingInterface("beside", "root"),
        ],
    )


@pytest.fixture(scope="module")
def solid_bar():
    mesh = block(1.0, 0.1, 0.06, 8, 1, 1, CellType.HEXA20)
    x = mesh.nodes[:, 0]
    ends = [
        AveragingInterface("root", np.flatnonzero(x < 1e-9)),
        AveragingInterface("tip", np.flatnonzero(x > 1 - 1e-9)),
    ]
    return flexible_body("bar", solid_model(mesh, STEEL), ends)


def beam_frame():
    """A T of beams: a stem along x and two arms along y."""
    stem, arm = np.linspace(0, 1, 17), np.linspace(0, 0.5, 11)[1:]
    points = np.vstack(
        [
            np.outer(stem, [1, 0, 0]),
            np.outer(arm, [0, 1, 0]) + np.eye(3)[0],
            np.outer(arm, [0, -1, 0]) + np.eye(3)[0],
        ]
    )
    cells = [(i, i + 1) for i in range(26)] + [(16, 27), *((i, i + 1) for i in range(27, 36))]
    section = BeamSection(STEEL, 1e-4, 1e-9, 2e-9, 2e-9, orientation=(0, 0, 1.0))
    model = shell_model(Mesh(points, {CellType.LINE2: np.array(cells)}), section)
    names = {"root": 0, "crown": 16, "left": 26, "right": 36}
    return flexible_body("frame", model, [AveragingInterface(name, [i]) for name, i in names.items()])


FRAME_PATHS = LoadPaths(
    [LoadPath("root", "crown", 17), LoadPath("crown", "left", 11), LoadPath("crown", "right", 11)]
)


@pytest.mark.parametrize(("name", "path"), [("shell_strip", 13), ("solid_bar", 9), ("frame", None)])
def test_mass_first_and_second_moments_are_those_of_the_elements(name, path, request):
    body = beam_frame() if name == "frame" else request.getfixturevalue(name)
    plan = FRAME_PATHS if path is None else LoadPath("root", "tip", path)
    line = condense(body, plan, support=FREE, n_modes=4).line
    R = nodal_rigid_modes(body.nodes - line.tree.points[0], body.dofs_per_node)
    exact = R.T @ (body.nodal_mass @ R)
    assert line.twists.T @ line.mass @ line.twists == pytest.approx(exact, abs=1e-12 * exact.max())
    assert np.linalg.eigvalsh(line.station_masses).min() > 0


@pytest.mark.parametrize("n_stations", [3, 5, 9])
def test_the_lumping_error_is_that_of_the_deflection_under_the_weight(shell_strip, n_stations):
    """Elements under their weight, and stations under that of their mass: the same places are compared."""
    path = LoadPath("root", "tip", n_stations)
    condensed = condense(shell_strip, path)
    stations, _ = path.stations(shell_strip)
    weight = shell_strip.mass @ shell_strip.rigid_modes[:, 2]
    bent = shell_strip.constrained(stations[0].motion).solve(weight)
    exact = np.array([each.motion @ bent for each in stations])
    line = condensed.line
    heavy = (line.mass @ line.twists[:, 2])[6:]
    lumped = np.linalg.solve(line.stiffness[6:, 6:], heavy).reshape(-1, 6)
    error = np.linalg.norm(lumped[:, 2] - exact[1:, 2]) / np.linalg.norm(exact[1:, 2])
    assert condensed.lumping_error == pytest.approx(error, rel=1e-4)
    # With rigid arms, moments of q h^2 / 12 at the tip bend a cantilever by (h / L)^2 / 3 too little.
    assert error < 0.4 / 3 / (n_stations - 1) ** 2


def frequencies(body, number, constraint):
    return np.sqrt(lowest_modes(body.stiffness, body.mass, number, constraint=constraint).values)


def test_frequencies_of_a_strip_are_those_of_its_mesh(shell_strip):
    exact = frequencies(shell_strip, 4, shell_strip.interface("root").motion.toarray())
    errors = []
    for n in (7, 13):
        found = condense(shell_strip, LoadPath("root", "tip", n), n_modes=12).modes.omega[:4]
        errors.append(np.abs(found / exact - 1))
    # Lumped mass is of second order in the length of a segment; on one mesh, slices lose some of it.
    assert np.all(np.log2(errors[0] / errors[1]) > 1.4)
    assert errors[1].max() < 0.02
    assert errors[1][0] < 5e-4


def test_frequencies_of_a_solid_bar_that_flies_are_those_of_its_mesh(solid_bar):
    R = solid_bar.mass @ solid_bar.rigid_modes
    exact = frequencies(solid_bar, 3, R.T)
    errors = []
    for n in (5, 9):
        modes = condense(solid_bar, LoadPath("root", "tip", n), support=FREE, n_modes=12).modes
        assert modes.n_rigid == 6
        assert max(modes.orthonormality) < 1e-11
        errors.append(np.abs(modes.omega[6:9] / exact - 1))
    assert np.all(np.log2(errors[0] / errors[1]) > 1.8)
    assert errors[1].max() < 0.005


def test_a_tree_of_beams_has_their_frequencies():
    body = beam_frame()
    exact = frequencies(body, 6, body.interface("root").motion.toarray())
    intrinsic = condense(body, FRAME_PATHS, n_modes=12)
    assert intrinsic.modes.omega[:6] == pytest.approx(exact, rel=0.01)
    assert not intrinsic.line.tree.is_chain
    assert intrinsic.interface("left").number == 26
    assert intrinsic.interface("station 3").position == pytest.approx([0.1875, 0, 0])


def test_stations_can_be_node_sets_of_ones_own(solid_bar):
    x = solid_bar.nodes[:, 0]
    middle = np.flatnonzero(np.abs(x - 0.5) < 1e-9)
    body = condense(solid_bar, NodeSetPath(["root", middle, "tip"]), n_modes=4)
    assert body.line.tree.points[1] == pytest.approx([0.5, *solid_bar.nodes[middle, 1:].mean(axis=0)])


def still(body, coordinates, rotation=None):
    """One instant of a body at rest in space."""
    return IntrinsicMotion(
        position=np.zeros((1, 3)),
        rotation=(np.eye(3) if rotation is None else rotation)[None],
        coordinates=np.asarray(coordinates)[None],
        velocity=np.zeros((1, 3)),
        angular_velocity=np.zeros((1, 3)),
        rates=np.zeros((1, body.modes.n_modes)),
    )


def test_small_amplitudes_move_the_nodes_by_the_linear_modes(solid_bar):
    body = condense(solid_bar, LoadPath("root", "tip", 9), n_modes=6)
    errors = []
    amplitudes = np.zeros(body.n_coordinates)
    amplitudes[:6] = [1.0, 0.5, -0.5, 0.2, 0.1, 0.1]
    for size in (1e-3, 1e-4):
        coordinates = size * amplitudes
        moved = body.positions(still(body, coordinates))[0] - body.nodes
        errors.append(np.abs(moved - body.expand(coordinates)).max() / np.abs(moved).max())
    assert errors[1] < 5e-3
    assert errors[0] < 0.05


def test_nodes_turn_with_the_root():
    body = condense(beam_frame(), FRAME_PATHS, n_modes=6)
    turn = np.array([[0, -1.0, 0], [1, 0, 0], [0, 0, 1]])
    coordinates = np.zeros(body.n_coordinates)
    coordinates[[0, 1, 5]] = [0.02, 0.01, 0.005]
    straight, turned = (body.positions(still(body, coordinates, each)) for each in (None, turn))
    assert turned == pytest.approx(straight @ turn.T, abs=1e-14)
    assert body.positions(still(body, coordinates), [3, 13]) == pytest.approx(straight[:, [3, 13]])


@pytest.fixture(scope="module")
def twenty_cells():
    """A strip of twenty cells along its length."""
    model = shell_model(strip(1.0, 0.1, 20, 2), HomogeneousSection(Isotropic(2.1e11, 0.0, 7850.0), 5e-3))
    return flexible_body("strip", model, (RigidInterface("root", "root"), RigidInterface("tip", "tip")))


@pytest.mark.parametrize(
    "n_stations",
    [10, 12, 20, *(pytest.param(n, marks=pytest.mark.slow) for n in (11, 15, 18, 19, 21))],
)
def test_every_number_of_stations_that_the_mesh_carries_works(twenty_cells, n_stations):
    """Of 20 cells: 12, 15, 18 to 20 stations shared a line of nodes between two slices of two lines."""
    found = condense(twenty_cells, LoadPath("root", "tip", n_stations), n_modes=2).modes.omega[:2]
    beam = np.sqrt(2.1e11 * 5e-3**2 / 12 / 7850.0)
    np.testing.assert_allclose(found, np.array([1.87510, 4.69409]) ** 2 * beam, rtol=1e-2)


@pytest.mark.parametrize("asked", [22, 23, 41, 60])
def test_the_advice_on_stations_holds(twenty_cells, asked):
    with pytest.raises(ModelError, match="use at most 21 stations"):
        condense(twenty_cells, LoadPath("root", "tip", asked))


def test_bad_paths_are_refused_with_the_number_and_the_remedy(shell_strip, solid_bar):
    with pytest.raises(ModelError, match=r"slice 1 .* has 0 nodes, .* use at most 17 stations"):
        condense(solid_bar, LoadPath("root", "tip", 40))
    with pytest.raises(ModelError, match="at least two stations"):
        LoadPath("root", "tip", 1)
    with pytest.raises(ModelError, match="no interface 'top'; did you mean 'tip'"):
        condense(shell_strip, LoadPath("root", "top", 5))
    with pytest.raises(ModelError, match="may not form a loop"):
        LoadPaths([LoadPath("root", "tip", 5), LoadPath("tip", "root", 5)])
    with pytest.raises(ModelError, match="begins at no end of an earlier path"):
        LoadPaths([LoadPath("root", "tip", 5), LoadPath("hub", "end", 5)])
    with pytest.raises(ModelError, match="coincide"):
        condense(shell_strip, LoadPath("root", "beside", 5))
    with pytest.raises(ModelError, match="at least one path"):
        LoadPaths([])
    assert condense(shell_strip, LoadPath("root", "tip", 5), n_modes=3).support is CLAMPED
