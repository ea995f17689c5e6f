"""Pictures of impacts: what touches is told apart, and round-off is not shown."""

import numpy as np
import pytest
from fixtures.explicit_bars import SOFT, bar, explicit_bar

from supple.body import RigidBody, flexible_body
from supple.fem import solid_model
from supple.integrate import Run, Solution, Statistics
from supple.machine import (
    At,
    Ball,
    Contact,
    Placed,
    RigidPlane,
    RigidSphere,
    SurfaceContact,
    System,
)
from supple.mesh import CellType, block, skin_of
from supple.methods.explicit import (
    NodalMotion,
    explicit_subdomain,
    modal_subdomain,
)
from supple.reduction import NormalModes
from supple.results.camera import Camera
from supple.results.colouring import DEFLECTION, PLASTIC_STRAIN, stress_colouring
from supple.simulation import simulate
from supple.viz import animate_run, run_curves, run_pictures
from supple.viz.contact_clearance import CLEARANCE, clear_of_contact
from supple.viz.depth_buffer import visible_triangles
from supple.viz.scene import Actor, obstacle_actor, scene_of

WALL = RigidPlane((4.0, 0.0, 0.0), (-1.0, 0.0, 0.0))
STILL = np.zeros((1, 1, 3))


def pressed(obstacle=WALL):
    """A bar whose tip is a little inside what it hits, and that obstacle."""
    system = System([explicit_bar(CellType.HEXA8)], contacts=[Contact(At("bar", "tip"), obstacle)])
    positions = system.placed("bar").positions() + np.array([1e-3, 0.0, 0.0])
    return system, {"bar": positions[None]}


def seen_from_behind(system, positions):
    """Numbers of the parts, 0 the bar and 1 the wall, seen where the wall is, from its far side."""
    bar = Actor(skin_of(system.placed("bar").body.mesh), positions["bar"])
    scene = scene_of([bar, obstacle_actor(WALL, STILL[:, 0], positions["bar"][0])])
    camera = Camera.looking(along=(-1.0, 0.1, -0.2), up=(0.0, 0.0, 1.0))
    plane, nearness = camera.project(scene.positions[0][scene.skin.triangles])
    corners = 100 * (plane - plane.min(axis=(0, 1)))
    shape = tuple(np.ceil(corners.max(axis=(0, 1))[::-1]).astype(int))
    found = visible_triangles(corners, nearness, shape).triangle
    return found >= len(bar.skin.triangles)


def test_a_nose_does_not_shine_through_the_wall():
    system, positions = pressed()
    inside = seen_from_behind(system, positions)
    shown = clear_of_contact(system, positions, STILL)
    behind = seen_from_behind(system, shown)
    # The wall is twice as wide as the bar: all that is seen of the bar would be seen through it.
    assert 0 < inside.mean() < 1
    assert behind.sum() > inside.sum()
    tip = system.node_numbers(At("bar", "tip"))
    assert 4.0 - shown["bar"][0, tip, 0] == pytest.approx(4.0 * CLEARANCE, rel=1e-9)
    others = np.setdiff1d(np.arange(len(shown["bar"][0])), tip)
    assert np.array_equal(shown["bar"][0, others], positions["bar"][0, others])
    assert positions["bar"][0, tip, 0] == pytest.approx(4.001)


def test_nodes_stand_before_an_obstacle_that_moves():
    ball = RigidSphere((4.45, 0.5, 0.5), 0.5, velocity=(1.0, 0.0, 0.0))
    system, positions = pressed(ball)
    offsets = np.array([[[-0.1, 0.0, 0.0]]])
    shown = clear_of_contact(system, positions, offsets)["bar"][0]
    gap = np.linalg.norm(shown - np.array([4.35, 0.5, 0.5]), axis=1) - 0.5
    assert gap.min() >= 4.0 * CLEARANCE * (1 - 1e-9)


def test_nodes_stand_before_the_faces_of_another_part():
    model = solid_model(block(1, 1, 1, 1, 1, 1, CellType.HEXA8), SOFT)
    block_behind = Placed(explicit_subdomain(model, name="block"), position=(4.0, 0.0, 0.0))
    touch = SurfaceContact(At("bar", "tip"), At("block", "root"))
    system = System([explicit_bar(CellType.HEXA8), block_behind], contacts=[touch])
    positions = {name: system.placed(name).positions()[None] for name in ("bar", "block")}
    positions["bar"] = positions["bar"] + np.array([1e-3, 0.0, 0.0])
    shown = clear_of_contact(system, positions, STILL[:, :0])
    tip = system.node_numbers(At("bar", "tip"))
    assert 4.0 - shown["bar"][0, tip, 0] == pytest.approx(4.999 * CLEARANCE, rel=1e-9)
    assert np.array_equal(shown["block"], positions["block"])


def test_stress_of_round_off_has_no_colour():
    part = explicit_bar(CellType.HEXA8)
    noise = 1e-12 * SOFT.youngs_modulus * np.random.default_rng(0).uniform(size=(2, 4))
    still = np.broadcast_to(part.nodes, (2, *part.nodes.shape))
    colouring = stress_colouring({"bar": part.model})

    def flying(stress):
        return NodalMotion(still, 0 * still, 0 * still, 0 * noise, np.ones((2, 4)), stress)

    assert not colouring.values(part, flying(noise), None).any()
    assert colouring.values(part, flying(1e6 * noise), None).any()
    assert stress_colouring({"other": part.model}).values(part, flying(noise), None) is None


def test_energies_of_round_off_are_no_curves(tmp_path, monkeypatch):
    panels = []
    monkeypatch.setattr(run_curves, "plot_time_history", lambda path, own, **_: panels.append(own) or path)
    monkeypatch.setattr(run_pictures, "draw_mesh", lambda path, *_, **__: path)
    times = np.linspace(0.0, 1.0, 5)
    energies = np.zeros((5, 8))
    energies[:, 0], energies[:, 6] = 1.0, 1e-14 * times
    still = np.zeros((5, 4))
    bar = explicit_bar(CellType.HEXA8)
    nodes = np.broadcast_to(bar.nodes, (5, *bar.nodes.shape))
    motion = NodalMotion(nodes, 0 * nodes, 0 * nodes, still, still + 1, still)
    solution = Solution(times, {"bar": motion}, {}, Statistics(), series={"energies": energies})
    run_pictures.draw_run(tmp_path, System([bar]), solution, {"bar": bar.mesh})
    ((energy,),) = panels
    assert [series.label for series in energy.series] == ["kinetic"]


@pytest.mark.slow
def test_a_film_shows_frames_elements_and_rigid_bodies_together(tmp_path):
    """A hammer on a hinge hits nothing: a rigid body on a modal bar, beside elements that fly."""
    modal = modal_subdomain(flexible_body("arm", bar(CellType.HEXA8)), NormalModes(2))
    head = RigidBody("head", 1.0, np.zeros(3), np.eye(3), {"eye": np.zeros(3)})
    flying = Placed(explicit_bar(CellType.HEXA8), position=(0, 3, 0))
    system = System(
        [modal, Placed(head, position=modal.interface("tip").position), flying],
        joints=[Ball(name="pin", first="arm.tip", second="head.eye")],
        contacts=[Contact(At("bar", "tip"), RigidPlane((4.5, 0, 0), (-1.0, 0, 0)))],
    )
    solution = simulate(system, Run(0.02, 0.01))
    meshes = {name: system.mesh_of(name) for name in ("arm", "bar")}
    elements = {name: bar(CellType.HEXA8) for name in meshes}
    for colouring in (stress_colouring(elements), PLASTIC_STRAIN, DEFLECTION):
        path = animate_run(tmp_path / "film.gif", system, solution, meshes, colouring=colouring)
        assert path.stat().st_size > 0
    drawn = {path.name for path in run_pictures.draw_run(tmp_path, system, solution, meshes)}
    assert {"arm-deformed.png", "bar-mesh.png", "machine.png", "energies.png", "joint-forces.png"} <= drawn
    assert "bar-deformed.png" not in drawn
