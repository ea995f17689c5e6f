"""Pictures of impacts: what touches is told apart, and round-off is not shown."""

import numpy as np
import pytest
from fixtures.explicit_bars import SOFT, explicit_bar

from supple.fem import solid_model
from supple.integrate import Solution, Statistics
from supple.machine import (
    At,
    Contact,
    Placed,
    RigidPlane,
    RigidSphere,
    SurfaceContact,
    System,
)
from supple.mesh import CellType, block
from supple.methods.explicit import (
    NodalMotion,
    explicit_subdomain,
)
from supple.viz import explicit_pictures, skin_of
from supple.viz.camera import Camera
from supple.viz.contact_clearance import CLEARANCE, clear_of_contact
from supple.viz.depth_buffer import visible_triangles
from supple.viz.explicit_pictures import COLOURINGS, draw_explicit
from supple.viz.obstacle_surface import obstacle_actor
from supple.viz.scene import Actor, scene_of

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
    flying = NodalMotion(still, 0 * still, 0 * noise, np.ones((2, 4)), noise)
    assert not COLOURINGS["von-mises"].values(part, flying).any()
    stressed = NodalMotion(still, 0 * still, 0 * noise, np.ones((2, 4)), 1e6 * noise)
    assert COLOURINGS["von-mises"].values(part, stressed).any()


def test_ways_and_energies_of_round_off_are_no_curves(tmp_path, monkeypatch):
    panels = []
    monkeypatch.setattr(
        explicit_pictures, "plot_time_history", lambda path, own, **_: panels.append(own) or path
    )
    times = np.linspace(0.0, 1.0, 5)
    energies = np.zeros((5, 8))
    energies[:, 0], energies[:, 6] = 1.0, 1e-14 * times
    solution = Solution(times, {}, {}, Statistics(), series={"energies": energies})
    way = np.column_stack([1.2 + 0.01 * times, 1e-15 * times, np.full(5, 0.3)])
    draw_explicit(tmp_path, solution, {"tip": way})
    (energy,), (x, y, z) = panels
    assert [series.label for series in energy.series] == ["kinetic"]
    assert x.series[0].values == pytest.approx(0.01 * times)
    assert not y.series[0].values.any()
    assert not z.series[0].values.any()
