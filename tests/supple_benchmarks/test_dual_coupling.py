"""Multipliers on interface velocities, and several time steps (theory page, dual coupling)."""

from dataclasses import replace
from functools import cache

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.linalg import eigh

from supple.errors import ModelError
from supple.fem import Isotropic, lumped_mass, solid_model
from supple.mesh import CellType, Mesh, block
from supple_benchmarks.explicit.dual_coupling import (
    Coupling,
    ElementSide,
    GravouilCombescure,
    ModalSide,
    PrakashHjelmstad,
    chosen_scheme,
    dual_march,
    interface_operator,
)
from supple_benchmarks.explicit.report import tables

MATERIAL = Isotropic(1.0, 0.3, 1.0)


def _half(start):
    mesh = block(4, 2, 2, 4, 2, 2, CellType.TETRA4)
    model = solid_model(Mesh(mesh.nodes + np.array([start, 0, 0]), mesh.cells, mesh.node_sets), MATERIAL)
    return model.mesh, model.stiffness.toarray(), lumped_mass(model)


def _freedoms(nodes):
    return (3 * np.asarray(nodes)[:, None] + np.arange(3)).ravel()


@cache
def halves():
    """A box held at its root, its first half in 39 modes, its second in elements."""
    (mesh1, K1, m1), (mesh2, K2, m2) = _half(0.0), _half(4.0)
    tip, root = _freedoms(mesh1.node_sets["tip"]), _freedoms(mesh2.node_sets["root"])
    inner = np.setdiff1d(np.arange(len(m1)), np.concatenate([_freedoms(mesh1.node_sets["root"]), tip]))
    basis = np.zeros((len(m1), 39))
    basis[tip, :27] = np.eye(27)
    basis[inner, :27] = -np.linalg.solve(K1[np.ix_(inner, inner)], K1[np.ix_(inner, tip)])
    basis[inner, 27:] = eigh(K1[np.ix_(inner, inner)], np.diag(m1[inner]))[1][:, :12]
    squares, T = eigh(basis.T @ K1 @ basis, basis.T @ (m1[:, None] * basis))
    rows = np.zeros((27, len(m2)))
    rows[np.arange(27), root] = -1
    Kj = jnp.asarray(K2)
    elements = ElementSide(m2, lambda u, t: -(Kj @ u), rows, K2)
    modes = basis @ T
    return Coupling(ModalSide(np.sqrt(squares), modes[tip]), elements), tip, root, mesh2


@cache
def monolithic():
    """Stiffness and mass of both halves on (modes, elements), continuity eliminated: the primal problem."""
    coupling, _, root, _ = halves()
    k, n = len(coupling.modal.frequencies), len(coupling.elements.mass)
    free = np.setdiff1d(np.arange(n), root)
    L = np.zeros((k + n, k + len(free)))
    L[:k, :k] = np.eye(k)
    L[k + root, :k] = coupling.modal.rows
    L[k + free, k:] = np.eye(len(free))
    K = np.zeros((k + n, k + n))
    K[:k, :k] = np.diag(coupling.modal.frequencies**2)
    K[k:, k:] = coupling.elements.stiffness
    M = np.concatenate([np.ones(k), coupling.elements.mass])
    return L, L.T @ K @ L, L.T @ (M[:, None] * L)


LIMIT = 0.5  # s, of the elements of this box: 2 / omega_max = 0.57


def _start(case):
    coupling, _, root, mesh = halves()
    L, K, M = monolithic()
    k = len(coupling.modal.frequencies)
    if case == "smooth":
        velocity = L @ eigh(K, M, subset_by_index=[0, 0])[1][:, 0]
    else:
        velocity = np.zeros(len(L))
        pulse = np.exp(-(((mesh.nodes[:, 0] - 7) / 0.7) ** 2))
        velocity[k + 3 * np.arange(len(pulse))] = pulse
        velocity[k + root] = 0
    return velocity[:k], velocity[k:]


def _marched(case, scheme, h, n):
    coupling = halves()[0]
    v1, v2 = _start(case)
    n_long = n // scheme.ratio
    return dual_march(
        coupling,
        scheme,
        h,
        n_long,
        modal=(np.zeros_like(v1), v1),
        elements=(np.zeros_like(v2), v2),
        every=max(1, n_long // 10),
    )


def _energy_change(motion):
    total = motion.energies.sum(axis=1)
    return total[-1] / total[0] - 1


@pytest.mark.slow
def test_one_step_for_both_is_the_primal_march():
    h, n = 0.4 * LIMIT, 400
    dual = _marched("smooth", GravouilCombescure(1), h, n)
    L, K, M = monolithic()
    k = dual.modal.shape[1]
    u = np.zeros(K.shape[0])
    v1, v2 = _start("smooth")
    v = np.linalg.lstsq(L, np.concatenate([v1, v2]), rcond=None)[0]
    inverse = np.linalg.inv(M)
    a = -inverse @ K @ u
    for _ in range(n):
        u = u + h * v + 0.5 * h**2 * a
        new = -inverse @ (K @ u)
        v, a = v + 0.5 * h * (a + new), new
    whole = L @ u
    size = np.abs(whole[k:]).max()
    assert np.abs(dual.elements[-1] - whole[k:]).max() < 1e-11 * size
    assert abs(_energy_change(dual)) < 1e-11
    assert dual.gap < 1e-13
    assert np.abs(dual.interface.sum(axis=1)).max() < 1e-11 * dual.energies.sum(axis=1)[0]


@pytest.mark.parametrize("scheme", [GravouilCombescure(1), PrakashHjelmstad(1)])
def test_both_schemes_are_one_at_ratio_one(scheme):
    reference = _marched("pulse", GravouilCombescure(1), 0.1 * LIMIT, 200)
    other = _marched("pulse", scheme, 0.1 * LIMIT, 200)
    assert np.abs(other.elements - reference.elements).max() < 1e-11


# Twice the table of the theory page: error of the displacements over their amplitude, energy lost.
TABLE = [
    ("smooth", GravouilCombescure(4), 8.4e-5, 1.9e-4),
    ("smooth", GravouilCombescure(10), 2.1e-4, 3.6e-4),
    ("smooth", PrakashHjelmstad(4), 3.0e-6, 3e-7),
    ("smooth", PrakashHjelmstad(10), 1.2e-4, 7e-5),
    ("pulse", PrakashHjelmstad(4), 2.6e-3, 0.024),
    ("pulse", PrakashHjelmstad(10), 2.4e-2, 0.094),
]


@pytest.mark.slow
@pytest.mark.parametrize(("case", "scheme", "error", "energy"), TABLE)
def test_several_time_steps_stay_within_twice_the_table(case, scheme, error, energy):
    h = LIMIT / 40
    reference = _marched(case, GravouilCombescure(1), h, 8000)
    motion = _marched(case, scheme, h, 8000)
    off = np.abs(motion.elements[-1] - reference.elements[-1]).max() / np.abs(reference.elements).max()
    assert off < 2 * error
    assert abs(_energy_change(motion)) < 2 * energy
    assert motion.gap < 1e-13


def test_the_scheme_of_gravouil_and_combescure_takes_energy_out_of_a_pulse():
    for ratio, lost in ((4, 0.137), (10, 0.21)):
        motion = _marched("pulse", GravouilCombescure(ratio), LIMIT / 40, 8000)
        assert -2 * lost < _energy_change(motion) < -0.5 * lost
        assert motion.gap < 1e-13
        assert motion.interface[-1].sum() < 0  # and the interface's work says so


def test_the_interface_operator_is_the_inverse():
    rng = np.random.default_rng(0)
    U, b = rng.standard_normal((7, 3)), rng.standard_normal(7)
    for own in (rng.uniform(1, 2, 7), np.eye(7) * 2 + 0.1):
        H = (np.diag(own) if own.ndim == 1 else own) + U @ U.T
        assert H @ np.asarray(interface_operator(own, U).solve(jnp.asarray(b))) == pytest.approx(b, abs=1e-12)


def test_interfaces_that_do_not_meet_are_refused():
    coupling = halves()[0]
    with pytest.raises(ModelError, match="do not match"):
        Coupling(ModalSide(coupling.modal.frequencies, coupling.modal.rows[:5]), coupling.elements)
    with pytest.raises(ModelError, match="ratio"):
        GravouilCombescure(0)


def test_the_chosen_scheme_takes_the_longest_long_step_that_is_stable():
    coupling, _, _, _ = halves()
    modal = 2 / coupling.modal.frequencies.max()
    short = modal / 4.6
    scheme = chosen_scheme(coupling, short, linear=True)
    assert isinstance(scheme, PrakashHjelmstad)
    assert scheme.ratio * short <= 0.9 * modal < (scheme.ratio + 1) * short
    chosen = chosen_scheme(coupling, short, linear=False, largest_ratio=2)
    assert chosen == GravouilCombescure(2)
    with pytest.raises(ModelError, match="limit of the"):
        chosen_scheme(coupling, 0.6, linear=True)


def test_a_motion_starts_with_its_initial_state():
    motion = _marched("pulse", GravouilCombescure(2), 0.1 * LIMIT, 20)
    (v1, v2), mass = _start("pulse"), halves()[0].elements.mass
    assert motion.times == pytest.approx(np.arange(11) * 0.2 * LIMIT)
    assert motion.energies[0] == pytest.approx([v1 @ v1 / 2, v2 @ (mass * v2) / 2])
    assert not motion.interface[0].any()


@pytest.mark.parametrize(("n_steps", "every"), [(10, 4), (10, 11), (0, 1), (10, 0)])
def test_outputs_that_do_not_reach_the_last_step_are_refused(n_steps, every):
    (v1, v2), coupling = _start("pulse"), halves()[0]
    with pytest.raises(ModelError, match="multiple of the steps per output"):
        dual_march(
            coupling,
            GravouilCombescure(1),
            0.1,
            n_steps,
            modal=(0 * v1, v1),
            elements=(0 * v2, v2),
            every=every,
        )


@pytest.mark.parametrize("number", [2.0, np.nan, np.inf, -1])
def test_steps_and_passes_that_are_no_whole_numbers_are_refused(number):
    with pytest.raises(ModelError, match="whole number of at least 1"):
        GravouilCombescure(number)
    with pytest.raises(ModelError, match="whole number of at least 2"):
        PrakashHjelmstad(4, number)


def test_the_long_step_stays_below_its_fraction_of_the_limit_of_the_modes():
    coupling = halves()[0]
    rigid = Coupling(ModalSide(np.zeros(39), coupling.modal.rows), coupling.elements)
    assert chosen_scheme(rigid, 0.1, linear=False, largest_ratio=7) == GravouilCombescure(7)
    modes = 2 / coupling.modal.frequencies.max()
    soft = Coupling(coupling.modal, replace(coupling.elements, stiffness=1e-3 * coupling.elements.stiffness))
    with pytest.raises(ModelError, match=r"at most .* s, 0.9 of the stability limit of the modes"):
        chosen_scheme(soft, 0.95 * modes, linear=True)


def test_each_study_of_the_report_has_a_table():
    report = {"dual_against_primal": 2e-13, "multi_time_step": [{"scheme": "gc", "energy": -0.15}]}
    (_, heads, rows), _ = tables(report)
    assert (heads, rows) == (["difference"], [["2e-13"]])
