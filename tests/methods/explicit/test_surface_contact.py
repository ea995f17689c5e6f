"""Contact between sub-domains: momentum, two bars that hit in closed form, limits, modal faces, refusals."""

from dataclasses import replace

import numpy as np
import pytest
from fixtures.explicit_bars import SOFT, stepped
from fixtures.frame_momentum import nodal_momentum as modal_momentum

from supple.body import flexible_body
from supple.errors import ModelError, ValidityWarning
from supple.fem import HomogeneousSection, Isotropic, shell_model, solid_model
from supple.integrate import Run, Solution, Statistics, Validity, run
from supple.machine import (
    At,
    FollowerPressure,
    Placed,
    Support,
    SurfaceContact,
    System,
)
from supple.mesh import CellType, Mesh, block, strip
from supple.mesh.outer_faces import outer_triangles
from supple.methods.explicit import (
    ENERGIES,
    ExplicitEngine,
    J2Plasticity,
    LinearHardening,
    explicit_shell,
    explicit_subdomain,
    modal_subdomain,
)
from supple.methods.explicit.deleted_faces import deletion_watch
from supple.methods.explicit.motions import NodalMotion
from supple.reduction import NormalModes
from supple.simulation import simulate

ROD = Isotropic(100.0, 0.0, 1.0)  # no lateral strain: a 1-D bar
SPEED_OF_SOUND = 10.0


def rods(v=0.1, cells=40, length=4.0, gap=0.0, **contact):
    """Two equal rods along x; the first flies into the second."""
    model = solid_model(block(length, 0.2, 0.2, cells, 1, 1, CellType.HEXA8), ROD)
    first = Placed(explicit_subdomain(model, name="first"), velocity=(v, 0, 0))
    second = Placed(explicit_subdomain(model, name="second"), position=(length + gap, 0, 0))
    touch = SurfaceContact(At("first", "tip"), At("second", "root"), **contact)
    return System([first, second], contacts=[touch])


def nodal_momentum(engine, solution, name):
    m = np.asarray(engine.built.model.mass)[engine.built.nodes[name]]
    motion = solution.bodies[name]
    return np.einsum("n,tni->ti", m, motion.velocities)


@pytest.mark.slow
def test_equal_rods_exchange_their_velocities_in_the_time_of_two_wave_travels():
    """1-D bar impact (St. Venant): contact lasts 2 L / c, then the first stands still and the second flies.

    The penalty yields like a piece of rod of a few cells, so all is late by a time that goes with the cell.
    """
    v, length = 0.1, 4.0
    duration, mass = 2 * length / SPEED_OF_SOUND, length * 0.2 * 0.2
    halfway, done = [], []
    for cells in (40, 80):
        span = Run(1.5 * duration, duration / 200)
        engine = ExplicitEngine(rods(v, cells, length), span)
        solution = run(engine, span.times)
        first, second = (nodal_momentum(engine, solution, name)[:, 0] / mass for name in ("first", "second"))
        assert first[-1] == pytest.approx(0.0, abs=0.02 * v)
        assert second[-1] == pytest.approx(v, rel=0.02)
        # The force is rho c v A / 2 throughout: the velocity of the second grows linearly, done at 2 L / c.
        halfway.append(np.interp(0.5 * v, second, solution.times))
        done.append(solution.times[np.argmax(second > 0.98 * v)])
        held = solution.series[ENERGIES][:, 4]
        assert held.max() > 1e-4 * mass * v**2
        assert abs(held[-1]) < 1e-2 * held.max()
    assert 2 * halfway[1] - halfway[0] == pytest.approx(0.5 * duration, rel=0.01)
    assert done[1] == pytest.approx(duration, rel=0.03)


@pytest.mark.slow
def test_an_oblique_hit_keeps_both_momenta_and_the_energy():
    """A turning cube hits the side of a finer one off its centre, meshes unlike."""
    hitting = explicit_subdomain(solid_model(block(1, 1, 1, 2, 2, 2, CellType.HEXA8), SOFT), name="cube")
    plate = explicit_subdomain(solid_model(block(0.4, 2, 2, 1, 5, 5, CellType.TETRA4), SOFT), name="plate")
    parts = [
        Placed(
            hitting, position=(-1.01, 0.55, 0.35), velocity=(1.0, 0.2, 0.1), angular_velocity=(0, 0.1, 0.2)
        ),
        Placed(plate),
    ]
    touch = SurfaceContact(At("cube", "tip"), At("plate", "root"))
    span = Run(0.6, 0.02)
    engine = ExplicitEngine(System(parts, contacts=[touch]), span)
    solution = run(engine, span.times)
    m = np.asarray(engine.built.model.mass)
    h = solution.series["steps"][:, 0]
    linear, angular = np.zeros((len(h), 3)), np.zeros((len(h), 3))
    for name, numbers in engine.built.nodes.items():
        x, v = solution.bodies[name].nodes, solution.bodies[name].velocities
        linear += np.einsum("n,tni->ti", m[numbers], v)
        angular += np.einsum("n,tni->ti", m[numbers], np.cross(x - h[:, None, None] * v, v))
    assert np.abs(linear - linear[0]).max() < 1e-13 * np.abs(linear).max() * 100
    assert np.abs(angular[1:] - angular[1]).max() < 1e-11 * np.abs(angular).max()
    e = solution.series[ENERGIES]
    assert e[:, 4].max() > 1e-3 * e[0, 0]
    assert np.abs(nodal_momentum(engine, solution, "plate")[-1]).max() > 0.1
    total = e[:, :7].sum(axis=1) - e[:, 7]
    assert np.abs(total / total[0] - 1).max() < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize("cells", [(2, 2), (3, 2), (1, 3)])
def test_the_stated_limit_is_below_the_true_one_with_all_contacts_closed(cells):
    """Penalties of all nodes on the faces below them, along the normal, against the bound on the step."""
    from supple.methods.explicit.march.touching_surface import projected

    mine, theirs = (
        explicit_subdomain(solid_model(block(1, 1, 1, 2, n, n, CellType.HEXA8), SOFT), name=name)
        for n, name in zip(cells, ("mine", "theirs"), strict=True)
    )
    touch = SurfaceContact(At("mine", "tip"), At("theirs", "root"), fraction=0.5)
    system = System([mine, Placed(theirs, position=(1, 0, 0))], contacts=[touch])
    model = ExplicitEngine(system, Run(1.0, 1.0)).built
    (surface,) = model.model.surfaces
    at = projected(surface, model.start.x)
    m = np.asarray(model.model.mass)
    K = np.zeros((len(m), len(m)))
    for i, node in enumerate(np.asarray(surface.nodes)):
        row = np.zeros(len(m))
        row[node] = 1.0
        row[np.asarray(at.corners)[i]] -= np.asarray(at.weights)[:, i]
        K += float(surface.stiffness[i]) * np.outer(row, row)
    largest = np.linalg.eigvalsh(K / np.sqrt(m[:, None] * m))[-1]
    assert 0.1 * float(model.model.contact_rate) < largest <= (1 + 1e-9) * float(model.model.contact_rate)


@pytest.mark.slow
@pytest.mark.parametrize("which", ["nodes", "surface"])
def test_the_face_of_a_modal_part_takes_part(which):
    """A cube hits a modal block: momenta go over exactly in equal steps, and it bounces."""
    body = flexible_body("block", solid_model(block(1, 1, 1, 3, 3, 3, CellType.TETRA4), SOFT))
    modal = modal_subdomain(body, NormalModes(12))
    cube = explicit_subdomain(solid_model(block(1, 1, 1, 2, 2, 2, CellType.HEXA8), SOFT), name="cube")
    ends = [At("cube", "root"), At("block", "tip")]
    touch = SurfaceContact(*(ends if which == "nodes" else ends[::-1]))
    parts = [modal, Placed(cube, position=(1.0, 0.1, 0.05), velocity=(-0.2, 0, 0))]
    span = Run(0.8, 0.05)
    engine = ExplicitEngine(System(parts, contacts=[touch]), stepped(span, largest_ratio=1))
    solution = run(engine, span.times)
    p = modal_momentum(engine, span.times, "block")[1][1:].sum(axis=1)
    p += nodal_momentum(engine, solution, "cube")[1:]
    assert np.abs(p - [-0.2, 0, 0]).max() < 1e-11
    assert nodal_momentum(engine, solution, "cube")[-1, 0] > -0.1
    e = solution.series[ENERGIES]
    assert e[:, 4].max() > 1e-3 * e[0, 0]
    total = e[:, :7].sum(axis=1) - e[:, 7]
    assert np.abs(total / total[0] - 1).max() < 1e-3


def test_what_cannot_touch_is_refused():
    # In the units of the machine, whatever they are.
    with pytest.raises(ModelError, match=r"starts 0\.02 inside the surface"):
        ExplicitEngine(rods(gap=-0.02, cells=4), Run(1.0, 1.0))
    with pytest.raises(ModelError, match="with itself is not supported"):
        SurfaceContact(At("first", "tip"), At("first", "root"))
    with pytest.raises(ModelError, match="stiffness of a contact"):
        rods(cells=4, stiffness=-1.0)


def sheet(turned=(), back=False):
    """A held sheet of 4 x 4 in the plane z = 0, normals along z; some triangles are turned over, or all."""
    mesh = strip(4.0, 4.0, 4, 4)
    cells = mesh.cells[CellType.TRIANGLE3].copy()
    cells[list(turned)] = cells[list(turned), ::-1]
    cells = cells[:, ::-1] if back else cells
    x, y = (mesh.nodes[:, :2] - mesh.nodes[:, :2].mean(axis=0)).T
    edge = np.flatnonzero(np.isclose(np.maximum(np.abs(x), np.abs(y)), 2.0))
    sets = {"all": np.arange(len(mesh.nodes)), "edge": edge}
    nodes = np.column_stack([x, y, np.zeros(len(x))])
    model = shell_model(
        Mesh(nodes, {CellType.TRIANGLE3: cells}, sets), HomogeneousSection(Isotropic(1e3, 0.3, 1.0), 0.2)
    )
    return explicit_shell(model, name="sheet")


@pytest.mark.parametrize("options", [{}, {"back": True}, {"turned": (3, 12, 13, 20)}], ids=str)
@pytest.mark.parametrize("gap", [0.0, 1.0])
def test_a_shell_is_touched_from_the_side_on_which_the_nodes_start(options, gap):
    """The faces of a shell have two sides: the same motion from below, whatever the normals of the mesh."""
    cube = explicit_subdomain(solid_model(block(1.0, 1.0, 1.0, 1, 1, 1, CellType.HEXA8), SOFT), name="cube")
    below = cube.nodes[:, 2].max() + gap
    centred = (-cube.nodes[:, 0].mean(), 0.0, -below)
    flying = Placed(cube, position=centred, velocity=(0.0, 0.0, 0.5))
    touch = SurfaceContact(At("cube", "z_max"), At("sheet", "all"))
    system = System([flying, sheet(**options)], contacts=[touch], supports=[Support(At("sheet", "edge"))])
    span = Run(2 * gap + 2.0, gap + 1.0)
    solution = run(ExplicitEngine(system, span), span.times)
    at = solution.bodies["cube"]
    assert at.nodes[..., 2].max() < 0.4
    assert at.velocities[-1, :, 2].mean() < 0.0


def breaking(nodes, surface):
    """A cube flies into a held bar of two elements that break early."""
    law = J2Plasticity(SOFT, LinearHardening(1.0, 0.0))
    mesh = block(2.0, 1.0, 1.0, 2, 1, 1, CellType.HEXA8)
    mesh = Mesh(mesh.nodes, mesh.cells, {**mesh.node_sets, "all": np.arange(len(mesh.nodes))})
    held = explicit_subdomain(solid_model(mesh, SOFT), law, name="bar", deletion=0.3)
    heavy = solid_model(block(1.0, 1.0, 1.0, 1, 1, 1, CellType.HEXA8), Isotropic(100.0, 0.3, 20.0))
    cube = Placed(explicit_subdomain(heavy, name="cube"), position=(-1.0, 0, 0), velocity=(1.0, 0, 0))
    return System(
        [held, cube],
        contacts=[SurfaceContact(At(*nodes.split(".")), At(*surface.split(".")))],
        supports=[Support(At("bar", "tip"))],
    )


@pytest.mark.slow
def test_a_run_warns_of_elements_deleted_below_the_faces_of_a_contact():
    """The faces of the element behind are not in the contact: the cube passes through it."""
    with pytest.warns(ValidityWarning, match="'bar.root': elements below its faces are deleted"):
        simulate(breaking("cube.tip", "bar.root"), Run(1.0, 0.5))


@pytest.mark.parametrize(("deleted", "found"), [(0, [0.5]), (1, [])])
def test_only_elements_below_the_faces_of_a_contact_are_watched(deleted, found):
    alive = np.ones((3, 2))
    alive[1:, deleted] = 0.0
    none = np.zeros((3, 0, 3))
    motion = NodalMotion(none, none, none, 0 * alive, alive, 0 * alive)
    leg = Solution(np.array([0.0, 0.5, 1.0]), {"bar": motion}, {}, Statistics())
    watch = deletion_watch(breaking("cube.tip", "bar.root"), Validity())
    assert list(watch.observe({}, leg).values()) == found
    assert not deletion_watch(breaking("bar.all", "cube.tip"), Validity()).below


def test_elements_below_a_pressure_are_watched():
    system = breaking("bar.all", "cube.tip")
    bar = system.placed("bar").body
    faces = outer_triangles(bar.mesh, bar.mesh.nodes_of("root"))
    pressed = replace(system, loads=[FollowerPressure(body="bar", faces=faces, pressure=1.0)])
    ((message, part, below),) = deletion_watch(pressed, Validity()).below
    assert "the pressure still acts on the nodes" in message.lower()
    assert (part, list(below)) == ("bar", [True, False])
