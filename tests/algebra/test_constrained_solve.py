from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse

import supple.algebra.constrained_solve as module
from supple.algebra import GroundedFactor, SparseFactor, constrained_factor, grounded_factor
from supple.errors import AccuracyError, ModelError


def kkt(stiffness, constraint, loads, values):
    """Dense reference: [K D^T; D 0] [x; mu] = [b; c], the multipliers in the scale of the stiffness."""
    K, D = stiffness.toarray(), np.asarray(constraint)
    scale = np.abs(K).max() / np.abs(D).max()
    matrix = np.block([[K, scale * D.T], [scale * D, np.zeros((len(D), len(D)))]])
    solution = np.linalg.solve(matrix, np.vstack([loads, scale * values]))
    return solution[: len(K)], scale * solution[len(K) :]


def held_nodes(truss, nodes):
    """Rows that hold the three freedoms of some nodes."""
    return np.eye(truss.stiffness.shape[0])[(3 * np.asarray(nodes)[:, None] + np.arange(3)).ravel()]


def mean_motion(truss, nodes):
    """Six rows: mean displacement and mean moment of displacement of some nodes."""
    rows = np.zeros((6, truss.stiffness.shape[0]))
    for node in nodes:
        rows[:, 3 * node : 3 * node + 3] = truss.rigid_modes[3 * node : 3 * node + 3].T / len(nodes)
    return rows


@pytest.fixture(
    params=["mean axis", "one end averaged", "both ends averaged", "three nodes held", "5 nodes held"]
)
def constraint(request, small_truss):
    last = len(small_truss.nodes) - 1
    if request.param == "mean axis":
        return (small_truss.mass @ small_truss.rigid_modes).T
    if request.param == "one end averaged":
        return mean_motion(small_truss, range(4))
    if request.param == "both ends averaged":
        return np.vstack(
            [mean_motion(small_truss, range(4)), mean_motion(small_truss, range(last - 3, last + 1))]
        )
    if request.param == "three nodes held":
        return held_nodes(small_truss, [0, 1, 2])
    return held_nodes(small_truss, [0, 1, 2, 3, last])


def test_a_free_body_with_constraints_solves_its_kkt_system(small_truss, constraint, solver, relative_error):
    n, m = small_truss.stiffness.shape[0], len(constraint)
    rng = np.random.default_rng(0)
    b, c = 1e5 * rng.standard_normal((n, 4)), 0.1 * rng.standard_normal((m, 4))
    x, mu = constrained_factor(
        small_truss.stiffness, constraint, small_truss.rigid_modes, solver=solver
    ).solve_with_multipliers(b, c)
    x_exact, mu_exact = kkt(small_truss.stiffness, constraint, b, c)
    assert relative_error(x, x_exact) < 1e-10
    assert relative_error(mu, mu_exact) < 1e-10


def test_a_held_body_with_and_without_constraints(small_truss, solver, relative_error):
    held = small_truss.stiffness[9:, 9:]
    n = held.shape[0]
    b = np.random.default_rng(1).standard_normal((n, 2))
    x = constrained_factor(held, None, solver=solver).solve(b)
    assert relative_error(x, np.linalg.solve(held.toarray(), b)) < 1e-10
    D, c = np.eye(n)[[5, 17]], np.array([[1.0, 0.0], [0.0, 2.0]])
    x, mu = constrained_factor(held, D, solver=solver).solve_with_multipliers(1e5 * b, c)
    x_exact, mu_exact = kkt(held, D, 1e5 * b, c)
    assert relative_error(x, x_exact) < 1e-10
    assert relative_error(mu, mu_exact) < 1e-10


def test_all_freedoms_can_be_given(small_truss, relative_error):
    """`x = c` and `mu = b - K c`; without values `x` is rounding."""
    K = small_truss.stiffness
    n = K.shape[0]
    rows = held_nodes(small_truss, range(n // 3)) @ np.linalg.qr(K.toarray() + 1e9 * np.eye(n))[0]
    rng = np.random.default_rng(0)
    b, x = 1e5 * rng.standard_normal((n, 2)), 0.1 * rng.standard_normal((n, 2))
    found, mu = constrained_factor(K, rows, small_truss.rigid_modes).solve_with_multipliers(b, rows @ x)
    assert relative_error(found, x) < 1e-10
    assert relative_error(rows.T @ mu, b - K @ x) < 1e-10


def test_mean_axis_multipliers_are_the_rigid_acceleration(truss, relative_error):
    # K x + M R a = b with R^T K = 0: a = (R^T M R)^-1 R^T b, inertia relief.
    R, D = truss.rigid_modes, (truss.mass @ truss.rigid_modes).T
    b = np.random.default_rng(2).standard_normal(len(R))
    x, mu = constrained_factor(truss.stiffness, D, R).solve_with_multipliers(b)
    assert relative_error(mu, np.linalg.solve(D @ R, R.T @ b)) < 1e-10
    assert relative_error(truss.stiffness @ x, b - D.T @ mu) < 1e-9
    assert np.max(np.abs(D @ x)) < 1e-12 * np.max(np.abs(D) @ np.abs(x))


def test_unit_values_at_one_end_with_the_other_free_move_the_body_rigidly(truss):
    D = mean_motion(truss, range(16))
    x, mu = constrained_factor(truss.stiffness, D, truss.rigid_modes).solve_with_multipliers(
        values=D @ truss.rigid_modes
    )
    np.testing.assert_allclose(x, truss.rigid_modes, atol=1e-11 * np.abs(truss.rigid_modes).max())
    assert np.max(np.abs(mu)) < 1e-8 * np.abs(truss.stiffness).max()


def test_shapes_follow_what_is_given(small_truss):
    n = small_truss.stiffness.shape[0]
    factor = constrained_factor(
        small_truss.stiffness, mean_motion(small_truss, range(4)), small_truss.rigid_modes
    )
    assert factor.n == n
    assert factor.solve(np.ones(n)).shape == (n,)
    assert factor.solve(np.ones((n, 1))).shape == (n, 1)
    assert factor.solve(values=np.ones(6)).shape == (n,)
    assert factor.solve(values=np.eye(6)).shape == (n, 6)
    assert factor.solve(np.zeros((n, 0))).shape == (n, 0)
    sparse_rows = sparse.csr_array(mean_motion(small_truss, range(4)))
    same = constrained_factor(small_truss.stiffness, sparse_rows, small_truss.rigid_modes)
    np.testing.assert_array_equal(same.solve(np.ones(n)), factor.solve(np.ones(n)))


def test_one_factor_serves_several_constraints(truss, monkeypatch, relative_error):
    grounded = grounded_factor(truss.stiffness, truss.rigid_modes)
    monkeypatch.setattr(module, "factorize_symmetric", None)
    b = np.random.default_rng(3).standard_normal(grounded.n)
    for D in (mean_motion(truss, range(16)), (truss.mass @ truss.rigid_modes).T):
        x, mu = constrained_factor(truss.stiffness, D, grounded=grounded).solve_with_multipliers(b)
        assert relative_error(truss.stiffness @ x + D.T @ mu, b) < 1e-9


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_six_determinate_springs_whatever_the_unit_of_length(truss, scale):
    modes = truss.rigid_modes * np.array([1, 1, 1, scale, scale, scale])
    springs = grounded_factor(truss.stiffness, modes).springs
    assert springs.size == 6
    held = modes[springs] / np.linalg.norm(modes, axis=0)
    assert np.linalg.cond(held) < 100


def test_redundant_rows_are_refused(small_truss):
    D = held_nodes(small_truss, [0, 1, 2])
    with pytest.raises(
        ModelError, match="10 constraint rows are linearly dependent or leave a rigid motion free"
    ):
        constrained_factor(small_truss.stiffness, np.vstack([D, D[:1] + D[4:5]]), small_truss.rigid_modes)


def test_a_zero_row_is_named(small_truss):
    D = held_nodes(small_truss, [0, 1, 2])
    D[4] = 0
    with pytest.raises(ModelError, match="constraint row 4 is zero"):
        constrained_factor(small_truss.stiffness, D, small_truss.rigid_modes)


def test_a_rigid_motion_left_free_is_named(small_truss):
    n = small_truss.stiffness.shape[0]
    x_only = np.eye(n)[0:24:3]  # many rows, none of which sees a translation along y
    with pytest.raises(ModelError, match="leaves rigid motion 1 free"):
        constrained_factor(small_truss.stiffness, x_only, small_truss.rigid_modes)
    two_nodes = held_nodes(
        small_truss, [0, len(small_truss.nodes) - 1]
    )  # may turn about the line through them
    with pytest.raises(
        ModelError, match="6 constraint rows are linearly dependent or leave a rigid motion free"
    ):
        constrained_factor(small_truss.stiffness, two_nodes, small_truss.rigid_modes)
    with pytest.raises(ModelError, match="3 constraint rows cannot fix 6 rigid motions"):
        constrained_factor(small_truss.stiffness, np.eye(n)[:3], small_truss.rigid_modes)


def test_rigid_modes_must_be_independent_and_fit(small_truss):
    R = small_truss.rigid_modes.copy()
    with pytest.raises(ModelError, match=r"rigid modes have shape \(10, 6\)"):
        grounded_factor(small_truss.stiffness, R[:10])
    R[:, 5] = R[:, 0]
    with pytest.raises(ModelError, match="6 rigid modes are linearly dependent"):
        grounded_factor(small_truss.stiffness, R)


def test_a_mechanism_beyond_the_rigid_modes_is_singular(small_truss, solver):
    with pytest.raises(AccuracyError, match="singular to working precision"):
        grounded_factor(small_truss.stiffness, small_truss.rigid_modes[:, :5], solver=solver)


def test_motions_that_are_not_rigid_are_found_out(small_truss):
    wrong = small_truss.rigid_modes.copy()
    wrong[:, 3] += 1e-3 * np.random.default_rng(4).standard_normal(len(wrong))
    with pytest.raises(
        AccuracyError, match=r"violates equilibrium by .*check the rigid modes of this stiffness"
    ):
        constrained_factor(small_truss.stiffness, mean_motion(small_truss, range(4)), wrong)


def test_an_inexact_factor_is_found_out(small_truss):
    grounded = grounded_factor(small_truss.stiffness, small_truss.rigid_modes)
    factor = grounded.factor

    class Inexact(SparseFactor):
        def __init__(self):
            self.n = factor.n

        def solve(self, loads):
            return factor.solve(loads) * (
                1 + 1e-6 * np.sin(np.arange(np.size(loads)).reshape(np.shape(loads)))
            )

    inexact = GroundedFactor(grounded.stiffness, grounded.rigid_modes, grounded.springs, Inexact())
    with pytest.raises(AccuracyError, match="violates equilibrium by"):
        constrained_factor(None, mean_motion(small_truss, range(4)), grounded=inexact)


def test_a_drifting_constraint_is_found_out(small_truss, monkeypatch):
    # Without rigid modes any multipliers balance the loads, so only the constraint itself can tell.
    honest = module.linalg.lu_solve
    monkeypatch.setattr(module.linalg, "lu_solve", lambda *args: 0.99 * honest(*args))
    held = small_truss.stiffness[9:, 9:]
    with pytest.raises(AccuracyError, match=r"violates equilibrium by .*e-1\d and its constraint by .*e-0\d"):
        constrained_factor(held, np.eye(held.shape[0])[[5, 17]])


def test_loads_and_values_of_the_wrong_shape(small_truss):
    n = small_truss.stiffness.shape[0]
    factor = constrained_factor(
        small_truss.stiffness, mean_motion(small_truss, range(4)), small_truss.rigid_modes
    )
    with pytest.raises(ModelError, match=r"loads have shape \(5,\); give \(60,\) or \(60, k\)"):
        factor.solve(np.ones(5))
    with pytest.raises(ModelError, match=r"constraint values have shape \(3,\); give \(6,\) or \(6, k\)"):
        factor.solve(np.ones(n), np.ones(3))
    with pytest.raises(ModelError, match="2 load columns but 3 columns of constraint values"):
        factor.solve(np.ones((n, 2)), np.ones((6, 3)))


def test_many_columns_are_solved_a_few_at_a_time(small_truss, monkeypatch):
    monkeypatch.setattr(module, "NUMBERS_AT_ONCE", 1)
    monkeypatch.setattr(module, "FEWEST_AT_ONCE", 2)
    n = small_truss.stiffness.shape[0]
    factor = constrained_factor(
        small_truss.stiffness, mean_motion(small_truss, range(4)), small_truss.rigid_modes
    )
    rng = np.random.default_rng(3)
    loads, values = rng.standard_normal((n, 5)), rng.standard_normal((len(factor.constraint), 5))
    x, mu = factor.solve_with_multipliers(loads, values)
    for i in range(5):
        alone, forces = factor.solve_with_multipliers(loads[:, i], values[:, i])
        np.testing.assert_allclose(x[:, i], alone, rtol=1e-9, atol=1e-9 * np.abs(alone).max())
        np.testing.assert_allclose(mu[:, i], forces, rtol=1e-9, atol=1e-9 * np.abs(forces).max())
