"""Beams in pictures: prisms of their sections, that turn with the nodes and show the stress of their ends."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from fixtures.beam_bodies import rectangle
from scipy.sparse import csc_array, diags_array
from scipy.spatial.transform import Rotation

from supple.body import FullBody, MeanAxisFrame, NodalFixedFrame, RigidInterface, flexible_body
from supple.errors import ModelError
from supple.fem import (
    Attached,
    BeamSection,
    CoupledBeamSection,
    HomogeneousSection,
    Isotropic,
    RodSection,
    Section,
    finite_element_model,
    shell_model,
)
from supple.integrate import FloatingMotion, Solution, Statistics
from supple.machine import GROUND, At, Fixed, Placed, System
from supple.mesh import CellType, Mesh, circular_section, plate, rectangular_section, walled_section
from supple.mesh.section_geometry import ROUND_CORNERS, Wall
from supple.quantities import von_mises_by_end, von_mises_history
from supple.reduction import CraigBampton, NoDerivatives, NoLoads, body_modes, reduce
from supple.results import body_surface
from supple.results.beam_skin import outlines
from supple.viz import Glyphs, animate_run, draw_run, surface_glyphs

STEEL = Isotropic(2.1e11, 0.3, 7850.0)
H, W = 0.3, 0.1
SHAPED = replace(rectangle(W, H), geometry=rectangular_section(H, W))
CIRCLE = circular_section(0.05, 0.04)
TUBE = BeamSection(
    Isotropic(7e10, 0.3, 2700.0), np.pi * 9e-4, 1e-6, 1e-6, 2e-6, orientation=(0, 1, 0), geometry=CIRCLE
)


def straight(n=2, length=2.0):
    nodes = np.linspace(0, length, n + 1)[:, None] * np.eye(3)[0]
    cells = np.column_stack([np.arange(n), np.arange(1, n + 1)])
    return Mesh(nodes, {CellType.LINE2: cells}, {"root": [0], "tip": [n]})


def areas(surface):
    a, b, c = np.moveaxis(surface.rest[surface.skin.triangles], 1, 0)
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2


def test_the_skin_of_a_rectangle_is_its_box():
    """Extent and area of two boxes; twelve triangles each, whose diagonals are no edges."""
    surface = body_surface(shell_model(straight(), SHAPED))
    np.testing.assert_allclose(np.ptp(surface.rest[3:], axis=0), [2.0, H, W])
    assert areas(surface).sum() == pytest.approx(2 * (2 * (H + W) + 2 * H * W))
    assert surface.skin.triangles.shape == (24, 3)
    assert (surface.skin.mesh_lines.sum(axis=1) == 2).all()
    assert surface.skin.triangles.min() == 3, "nodes themselves are not on the skin"


def test_a_tube_is_open():
    """Area of both sides and of the two rings, of polygons of sixteen corners."""
    surface = body_surface(shell_model(straight(1), TUBE))
    n, angle = ROUND_CORNERS, np.pi / ROUND_CORNERS
    around = 2 * n * np.sin(angle) * (0.05 + 0.04) * 2.0
    rings = 2 * n * np.sin(angle) * np.cos(angle) * (0.05**2 - 0.04**2)
    assert areas(surface).sum() == pytest.approx(around + rings)


def test_walls_are_drawn_one_by_one_and_tapered():
    def tee(scale):
        walls = [Wall(0.1 * scale, 0, 0.02 * scale, 0.2 * scale), Wall(0, 0, 0.18 * scale, 0.02 * scale)]
        return replace(SHAPED, geometry=walled_section(walls))

    surface = body_surface(shell_model(straight(1), replace(tee(1.0), second=tee(0.5))))
    points = surface.rest[2:]
    assert len(points) == 2 * 2 * 4
    first, second = points[:8], points[8:]
    assert np.ptp(first[:, 2]) == pytest.approx(0.2)
    np.testing.assert_allclose(second[:, 1:], 0.5 * first[:, 1:])


def test_sections_without_shape_are_ellipses_of_their_radii_of_gyration():
    """A thin tube by its numbers, and by its mass matrix beside the axis, has the radius of the tube."""
    r, t = 0.1, 1e-4
    area, second = 2 * np.pi * r * t, np.pi * r**3 * t
    plain = BeamSection(Isotropic(7e10, 0.3, 2700.0), area, second, second, 2 * second, orientation=(0, 1, 0))
    moved = replace(plain, neutral=(0.03, -0.02), mass_centre=(0.03, -0.02))
    matrix = CoupledBeamSection(np.eye(6), moved.inertia(np.zeros(1))[0], (0, 1, 0))
    for section, centre in ((plain, (0, 0)), (moved, (0.03, -0.02)), (matrix, (0.03, -0.02))):
        (loop,), hole = outlines(section, 0)
        np.testing.assert_allclose(np.linalg.norm(loop - centre, axis=1), r, rtol=1e-6)
        assert not len(hole)
    (flat,), _ = outlines(replace(plain, I1=4 * second, I12=0.5 * second), 0)
    S = flat.T @ flat / len(flat)
    np.testing.assert_allclose(S * area, [[4 * second, 0.5 * second], [0.5 * second, second]], rtol=1e-9)
    (bar,), _ = outlines(RodSection(STEEL, np.pi * 0.02**2), 0)
    np.testing.assert_allclose(np.linalg.norm(bar, axis=1), 0.02)


def test_points_turn_with_their_nodes():
    rng = np.random.default_rng(0)
    surface = body_surface(shell_model(straight(), TUBE))
    R, shift = Rotation.random(random_state=1).as_matrix(), rng.normal(size=3)
    nodes = surface.mesh.nodes @ R.T + shift
    found = surface.placed(nodes[None], np.broadcast_to(R, (1, 3, 3, 3)))
    np.testing.assert_allclose(found[0], surface.rest @ R.T + shift, atol=1e-12)
    small = 1e-7 * rng.normal(size=(1, 3, 3))
    turned = surface.placed(surface.mesh.nodes[None], Rotation.from_rotvec(small[0]).as_matrix()[None])
    linear = surface.shaped(np.zeros((1, 3, 3)), small)
    np.testing.assert_allclose(turned - surface.rest, linear, atol=1e-13)


def test_torsion_shows_in_mode_shapes():
    """Nodes on the axis of a shaft do not move, its surface does."""
    model = shell_model(straight(4), replace(TUBE, J=1e-9))
    body = flexible_body("shaft", model, [RigidInterface("root", "root")])
    modes = body_modes(body, body.interface("root").motion, n_modes=1)
    surface = body_surface(model)
    moved = surface.shaped(modes.shapes, modes.rotations)
    on_axis, around = (np.abs(moved[0, part]).max() for part in (slice(5), slice(5, None)))
    assert on_axis < 1e-9 * around


def test_stress_at_a_node_is_that_of_each_end():
    """Two bars on one node, one in tension; and a beam without points, which is plain."""
    nodes = np.array([[0, 0, 0], [1.0, 0, 0], [1.0, 1.0, 0], [2.0, 0, 0]])
    cells = np.array([[0, 1], [1, 2], [1, 3]])
    bar, bare = (replace(own, orientation=(0, 0, 1)) for own in (TUBE, rectangle(W, H)))
    sections = tuple(Section(CellType.LINE2, np.array([k]), own) for k, own in enumerate((bar, bare, bar)))
    model = finite_element_model(Mesh(nodes, {CellType.LINE2: cells}), sections)
    full = FullBody(flexible_body("bars", model), MeanAxisFrame())
    u = np.zeros((1, 24))
    u[0, 0] = -1e-5
    by_end = von_mises_by_end(full, model, u)
    np.testing.assert_allclose(by_end[0, 1], [0, 7e5, 0], rtol=1e-4)
    np.testing.assert_allclose(by_end.max(axis=2), von_mises_history(full, model, u))
    surface = body_surface(model)
    values = surface.at_points(by_end)[0, 4:]
    first, plain, second = np.split(values, [4 * ROUND_CORNERS, 6 * ROUND_CORNERS])
    assert first.shape == second.shape
    np.testing.assert_allclose(first, 7e5, rtol=1e-4)
    assert np.isnan(plain).all()
    assert not second.any()


def test_shells_and_beams_in_one_picture():
    flat = plate(1.0, 1.0, 2, 2)
    mesh = Mesh(flat.nodes, {**flat.cells, CellType.LINE2: np.array([[0, 1]])})
    kinds = (CellType.TRIANGLE3, CellType.LINE2)
    properties = (HomogeneousSection(STEEL, 0.01), replace(SHAPED, orientation=(0, 0, 1)))
    sections = tuple(
        Section(kind, np.arange(len(mesh.cells[kind])), own)
        for kind, own in zip(kinds, properties, strict=True)
    )
    surface = body_surface(finite_element_model(mesh, sections))
    assert len(surface.skin.triangles) == len(flat.cells[CellType.TRIANGLE3]) + 12
    assert set(surface.groups) == {0, 1}
    assert body_surface(flat).skin.triangles.shape == flat.cells[CellType.TRIANGLE3].shape
    with pytest.raises(ModelError, match="a mesh of beams alone has no skin"):
        body_surface(straight())


def test_lines_alone_are_something_to_draw():
    assert not Glyphs(np.zeros((1, 1, 2, 3)), ()).is_empty
    assert Glyphs(np.zeros((1, 0, 2, 3)), ()).is_empty


def test_masses_and_ties_are_glyphs():
    mass = np.zeros(18)
    mass[[12, 13, 14]] = 5.0
    mesh = replace(straight(), links=np.array([[2, 0], [1, 1]]))
    model = finite_element_model(
        mesh,
        (Section(CellType.LINE2, np.arange(2), SHAPED),),
        attached=Attached(mass=csc_array(diags_array(mass))),
    )
    glyphs = surface_glyphs(body_surface(model), mesh.nodes[None])
    np.testing.assert_array_equal(glyphs.thin_lines, mesh.nodes[[2, 0]][None, None])
    np.testing.assert_array_equal(glyphs.marks[0].places, mesh.nodes[[[2]]])
    plain = body_surface(shell_model(straight(), SHAPED))
    assert surface_glyphs(plain, mesh.nodes[None]) is None


@pytest.mark.parametrize("form", ["full", "reduced"])
def test_rotations_of_nodes(form):
    """Those of the frame times those of the nodes' rotation vectors."""
    body = flexible_body("beam", shell_model(straight(), SHAPED), [RigidInterface("root", "root")])
    full = FullBody(body, NodalFixedFrame("root"))
    own = (
        full
        if form == "full"
        else reduce(
            body, NodalFixedFrame("root"), CraigBampton(2), derivatives=NoDerivatives(), loads=NoLoads
        )
    )
    q = 0.1 * np.random.default_rng(0).normal(size=(2, own.n_coordinates))
    R = Rotation.random(2, random_state=2).as_matrix()
    zero = np.zeros((2, 3))
    motion = FloatingMotion(zero, R, q, zero, zero, 0 * q, zero, zero, 0 * q)
    found = own.node_rotations(motion)
    moved, condensed = own.nodal_fields(q)
    fields = moved if condensed is None else moved + condensed
    theta = fields.T.reshape(2, -1, 6)[..., 3:]
    local = Rotation.from_rotvec(theta.reshape(-1, 3)).as_matrix().reshape(2, -1, 3, 3)
    np.testing.assert_allclose(found, R[:, None] @ local, atol=1e-12)


@pytest.mark.slow
def test_a_run_of_beams_is_drawn(tmp_path):
    """All pictures, coloured by stress; a body without elements is drawn by its points."""
    model = shell_model(straight(4), SHAPED)
    body = flexible_body("beam", model, [RigidInterface("root", "root")])
    own = reduce(body, NodalFixedFrame("root"), CraigBampton(2), derivatives=NoDerivatives(), loads=NoLoads)
    other = replace(own, name="black box")
    q = np.linspace(0, 0.1, 3)[:, None] * np.ones(own.n_coordinates)
    still, axes = np.zeros((3, 3)), np.tile(np.eye(3), (3, 1, 1))
    motion = FloatingMotion(still, axes, q, still, still, 0 * q, still, still, 0 * q)
    clamp = Fixed(first=GROUND, second=At("beam", "root"), name="clamp")
    system = System((Placed(own), Placed(other)), (clamp,))
    motions = {"beam": motion, "black box": motion}
    solution = Solution(np.arange(3.0), motions, {"clamp": np.zeros((3, 6))}, Statistics(0, 0, 0, 0.0, 0.0))
    looks = {"beam": model, "black box": None}
    pictures = draw_run(tmp_path, system, solution, looks, elements={"beam": model})
    names = {path.name for path in pictures}
    assert {"beam-mesh.png", "beam-modes.png", "beam-deformed.png", "beam-stress.png", "machine.png"} <= names
    film = animate_run(tmp_path / "motion.gif", system, solution, looks, elements={"beam": model})
    assert film is not None
    assert film.stat().st_size > 1000
