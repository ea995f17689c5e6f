"""Constitutive laws: energy, closed forms, objectivity."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from supple.errors import ModelError
from supple.fem import Isotropic
from supple.methods.explicit.materials import (
    J2Plasticity,
    LinearHardening,
    NeoHookean,
    PowerHardening,
    StVenantKirchhoff,
)
from supple.methods.explicit.materials.law import lame
from supple.methods.explicit.tensor3 import tensor

METAL = Isotropic(200.0, 0.3, 1.0)
LAMBDA, MU = lame(METAL)


def at(matrix):
    return tensor(lambda i, j: jnp.asarray(matrix[i][j], dtype=float)[None])


def piola(law, F, dF=((0, 0, 0),) * 3, state=None):
    out = law.respond(at(F), at(dF), law.initial((1,)) if state is None else state)
    return np.array([[np.asarray(out.stress[i][j])[0] for j in range(3)] for i in range(3)]), out


def svk_energy(F):
    E = 0.5 * (F.T @ F - jnp.eye(3))
    return 0.5 * LAMBDA * jnp.trace(E) ** 2 + MU * jnp.sum(E * E)


def neo_hookean_energy(F):
    J = jnp.linalg.det(F)
    return 0.5 * MU * (jnp.sum(F * F) - 3) - MU * jnp.log(J) + 0.5 * LAMBDA * jnp.log(J) ** 2


@pytest.mark.parametrize(
    ("law", "energy"), [(StVenantKirchhoff(METAL), svk_energy), (NeoHookean(METAL), neo_hookean_energy)]
)
def test_stress_is_the_derivative_of_the_energy(law, energy):
    F = np.eye(3) + 0.2 * np.random.default_rng(0).standard_normal((3, 3))
    stress, out = piola(law, F)
    assert stress == pytest.approx(np.asarray(jax.jit(jax.grad(energy))(F)), rel=1e-12)
    assert float(out.volume_ratio[0]) == pytest.approx(np.linalg.det(F))


def _pulled(law, stretch, n):
    """Uniaxial strain in n steps: Piola stress, plastic strain and dissipation."""
    state, before, dissipated = law.initial((1,)), np.eye(3), 0.0
    for F in (np.diag([1 + (stretch - 1) * (i + 1) / n, 1, 1]) for i in range(n)):
        stress, out = piola(law, F, F - before, state)
        state, before = out.state, F
        dissipated += float(out.dissipated[0])
    return stress, float(state.strain[0]), dissipated


@pytest.mark.slow
def test_uniaxial_plastic_strain_follows_its_closed_form():
    """sigma_eq = 2 mu e - 3 mu p = s0 + H p in logarithmic strain e, sigma_x = K e + 2/3 sigma_eq."""
    law = J2Plasticity(METAL, LinearHardening(1.0, 30.0))
    stretch = 1.1
    strain = np.log(stretch)
    plastic = (2 * MU * strain - 1.0) / (3 * MU + 30.0)
    stress = (LAMBDA + 2 * MU / 3) * strain + 2 / 3 * (1.0 + 30.0 * plastic)
    P, p, dissipated = _pulled(law, stretch, 200)
    assert p == pytest.approx(plastic, rel=1e-5)
    assert P[0, 0] == pytest.approx(stress, rel=1e-5)
    assert dissipated == pytest.approx(plastic * (1.0 + 15.0 * plastic), rel=0.07)  # per undeformed volume


@pytest.mark.slow
def test_the_strain_increment_is_of_second_order():
    law = J2Plasticity(METAL, LinearHardening(1.0, 30.0))
    exact = (2 * MU * np.log(1.3) - 1.0) / (3 * MU + 30.0)
    errors = [abs(_pulled(law, 1.3, n)[1] - exact) for n in (10, 20, 40)]
    assert np.polyfit(np.log([4, 2, 1]), np.log(errors), 1)[0] == pytest.approx(2.0, abs=0.1)


def test_stress_turns_with_the_material():
    law = J2Plasticity(METAL, LinearHardening(1.0))
    state = law.initial((1,))._replace(stress=jnp.array([[0.3], [-0.1], [0.2], [0.05], [0.1], [-0.2]]))
    turn = Rotation.from_rotvec([0.0, 0.0, 0.05]).as_matrix()
    F, before = np.eye(3), state
    for _ in range(20):
        _, out = piola(law, turn @ F, turn @ F - F, before)
        F, before = turn @ F, out.state
    s = np.asarray(state.stress)[:, 0]
    old = np.array([[s[0], s[5], s[4]], [s[5], s[1], s[3]], [s[4], s[3], s[2]]])
    s = np.asarray(before.stress)[:, 0]
    new = np.array([[s[0], s[5], s[4]], [s[5], s[1], s[3]], [s[4], s[3], s[2]]])
    whole = np.linalg.matrix_power(turn, 20)
    assert new == pytest.approx(whole @ old @ whole.T, abs=1e-3)
    assert np.linalg.eigvalsh(new) == pytest.approx(np.linalg.eigvalsh(old), rel=1e-10)


@pytest.mark.parametrize("hardening", [LinearHardening(2.0, 5.0), PowerHardening(2.0, 5.0, 0.3)])
def test_the_returned_stress_lies_on_the_yield_surface(hardening):
    trial, strain = jnp.array([1.0, 2.5, 40.0]), jnp.array([0.0, 0.001, 0.2])
    d = hardening.multiplier(trial, strain, 3 * MU)
    yields = trial > hardening.yield_stress(strain)
    left = jnp.where(yields, trial - 3 * MU * d - hardening.yield_stress(strain + d), d)
    assert np.abs(left).max() < 1e-10
    assert (np.asarray(d) >= 0).all()


def test_impossible_hardening_is_refused():
    with pytest.raises(ModelError, match="yield stress"):
        LinearHardening(0.0)
    with pytest.raises(ModelError, match="softening"):
        LinearHardening(1.0, -3.0)
    with pytest.raises(ModelError, match="exponent"):
        PowerHardening(1.0, 1.0, 1.5)
