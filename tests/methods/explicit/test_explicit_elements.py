"""Explicit finite elements by definition: patch, rigid motion, the implicit model's force, step limit."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from fixtures.explicit_bars import KINDS, SOFT, explicit_bar
from scipy.spatial.transform import Rotation

from supple.errors import ModelError
from supple.fem import Isotropic, solid_model
from supple.fem.quadratic_strain import internal_force
from supple.integrate import Run
from supple.machine import System
from supple.mesh import CellType, block
from supple.methods.explicit import ExplicitEngine
from supple.methods.explicit.elements import ElementInstant
from supple.methods.explicit.explicit_subdomain import explicit_subdomain
from supple.methods.explicit.march.nodal_forces import explicit_forces
from supple.methods.explicit.materials import J2Plasticity, LinearHardening, NeoHookean, StVenantKirchhoff

LAWS = (StVenantKirchhoff(SOFT), NeoHookean(SOFT), J2Plasticity(SOFT, LinearHardening(1.0, 10.0)))
STEEP = np.array([[1.02, 0.03, -0.01], [0.0, 0.97, 0.02], [0.01, 0.0, 1.01]])


def forces(subdomain, x, dx=None):
    """Internal and hourglass force (2, 3, N) at positions x (N, 3)."""
    engine = ExplicitEngine(System([subdomain]), Run(1.0, 1.0))
    own = engine.built
    back = np.empty_like(x)
    numbers = own.nodes[subdomain.name]
    back[numbers] = x
    moves = np.zeros_like(x)
    moves[numbers] = x - subdomain.nodes if dx is None else dx
    start = own.start
    at = ElementInstant(jnp.asarray(back.T), jnp.asarray(moves.T), jnp.ones(()), start.turning.triads)
    compiled = jax.jit(lambda at: explicit_forces(own.model, start.time, at, start.blocks, ()))
    out = compiled(at)
    return np.asarray(out.forces[:2])[:, :, numbers], out


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_a_patch_of_uniform_strain_leaves_its_inner_nodes_alone(kind, law):
    part = explicit_bar(kind, law, (3, 2, 2), 0.0 if kind is CellType.TETRA10 else 0.08)
    x = part.nodes @ STEEP.T
    (internal, hourglass), out = forces(part, x)
    inside = np.all((part.nodes > part.nodes.min(0) + 1e-9) & (part.nodes < part.nodes.max(0) - 1e-9), axis=1)
    assert inside.any()
    assert np.abs(internal).max() > 0.01
    assert np.abs(internal[:, inside]).max() < 1e-13 * np.abs(internal).max() * 100
    assert np.abs(hourglass).max() < 1e-12
    assert float(out.smallest) == pytest.approx(np.linalg.det(STEEP), rel=1e-12)


@pytest.mark.parametrize(
    ("kind", "law"),
    [
        pytest.param(
            kind,
            law,
            id=f"{kind.name}-{type(law).__name__}",
            marks=() if KINDS.index(kind) == LAWS.index(law) else pytest.mark.slow,
        )
        for kind in KINDS
        for law in LAWS
    ],
)
def test_rigid_motion_of_any_size_has_no_force(kind, law):
    part = explicit_bar(kind, law)
    turn = Rotation.from_rotvec([0.9, -1.3, 0.4]).as_matrix()
    (internal, hourglass), _ = forces(part, part.nodes @ turn.T + [3.0, 1.0, 2.0])
    assert np.abs(internal).max() < 1e-12
    assert np.abs(hourglass).max() < 1e-12


@pytest.mark.parametrize("kind", [CellType.TETRA4, CellType.TETRA10], ids=lambda kind: kind.name)
def test_the_force_is_that_of_the_quadratic_strains(kind):
    part = explicit_bar(kind)
    u = 0.05 * np.random.default_rng(3).standard_normal(part.nodes.shape)
    (internal, _), _ = forces(part, part.nodes + u)
    block_ = part.model.blocks[0]
    expected = np.zeros(part.model.n_dofs)
    np.add.at(expected, block_.dofs, internal_force(block_, u.ravel()[block_.dofs]))
    assert internal.T.ravel() == pytest.approx(-expected, abs=1e-12 * np.abs(expected).max())


def true_limit(part):
    """2 / omega_max of the linearised force at rest with the lumped mass."""
    engine = ExplicitEngine(System([part]), Run(1.0, 1.0))
    own = engine.built

    def force(x):
        at = ElementInstant(
            x.reshape(3, -1), jnp.zeros_like(own.start.x), jnp.ones(()), own.start.turning.triads
        )
        out = explicit_forces(own.model, own.start.time, at, own.start.blocks, ())
        return -out.forces.sum(axis=0).ravel()

    K = np.asarray(jax.jit(jax.jacobian(force))(own.start.x.ravel()))
    root = np.sqrt(np.tile(np.asarray(own.model.mass), 3))
    return 2 / np.sqrt(np.linalg.eigvalsh(K / root[:, None] / root)[-1])


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_the_step_limit_is_below_the_true_one_and_near_it(kind):
    part = explicit_bar(kind, counts=(5, 2, 2))
    limit = true_limit(part)
    assert 0.6 * limit < part.step_limit <= limit


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_lumped_mass_is_positive_and_complete(kind):
    part = explicit_bar(kind)
    assert part.masses.min() > 0
    assert part.masses.sum() == pytest.approx(4.0)


def test_hourglass_control_resists_what_one_point_does_not_see():
    part = explicit_bar(CellType.HEXA8, counts=(1, 1, 1))
    pattern = np.sign(part.nodes[:, 1] * part.nodes[:, 2]) * np.sign(part.nodes[:, 0] - 2)
    u = 0.01 * pattern[:, None] * [1.0, 0.0, 0.0]
    (internal, hourglass), _ = forces(part, part.nodes + u)
    assert np.abs(internal).max() < 1e-11 * np.abs(hourglass).max()
    assert (hourglass.T * u).sum() < 0


def test_cells_without_an_explicit_element_are_refused():
    model = solid_model(block(1, 1, 1, 1, 1, 1, CellType.HEXA20), SOFT)
    with pytest.raises(ModelError, match="HEXA20"):
        _ = explicit_subdomain(model).points


def test_two_materials_are_refused():
    mesh = block(2, 1, 1, 2, 1, 1, CellType.HEXA8)
    sets = {name: {CellType.HEXA8: np.array([number])} for number, name in enumerate("ab")}
    mesh = type(mesh)(mesh.nodes, mesh.cells, mesh.node_sets, sets)
    model = solid_model(mesh, {"a": SOFT, "b": Isotropic(50.0, 0.3, 1.0)})
    with pytest.raises(ModelError, match="2 materials"):
        explicit_subdomain(model)
