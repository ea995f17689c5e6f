"""Each family of primitives in C against JAX, on random arrays."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from fixtures.compiled_c import by_c, needs_compiler
from jax import lax

from supple.errors import ModelError
from supple.export.c import blocks, separate_functions
from supple.export.c.function import function_source

RANDOM = np.random.default_rng(1)
A, B, V = RANDOM.normal(size=(5, 7)), RANDOM.normal(size=(7, 4)), RANDOM.normal(size=7)
S, T = RANDOM.normal(size=(6, 6)), RANDOM.normal(size=(2, 3, 4))
TWO, SCALAR = np.int64(2), np.float64(0.7)


def _elementwise(a, b, s):
    return (
        jnp.sin(a) + b.T.sum() * a**3 - jnp.where(a > 0, a, jnp.abs(b[0, 0])),
        (jnp.maximum(a, 0.2), jnp.minimum(a, s), jnp.clip(a, -0.5, s), jnp.sign(a), a > 0),
        (jnp.round(a * 3).astype(int) % 3, (a * 3).astype(int) // 2, a % 0.3, jnp.floor(a), a**-2),
        (jnp.arctan2(a, a * 2), jnp.hypot(a, a), jnp.sinc(a), jnp.isfinite(a / 0.0), jnp.sqrt(a)),
        jnp.maximum(jnp.sqrt(a), s),
    )


def _shapes(a, b, t, s):
    return (
        (a * b[:, 0], a + b[:, 0][None] * 2, jnp.outer(a[0], a[1])[::-1, ::2], (a * 2)[1:3, 2:]),
        (jnp.concatenate([a, b.T], axis=0), jnp.stack([s, s * 2, s]), jnp.pad(a, ((1, 2), (0, 3)))),
        jnp.block([[a, a * 2], [jnp.zeros((2, 14))]]),
        (t.reshape(6, 4) * 2, (t + 1).reshape(-1), t.transpose(2, 0, 1).reshape(8, 3), t[:, 1:2].squeeze(1)),
        (jnp.unstack(t * 2, axis=1), jnp.unstack(a), jnp.unstack(jnp.zeros((2, 3)))),
        (jnp.split(t * 2, 2, axis=2), jnp.eye(3) * s, lax.pad(a, s, ((-1, 1, 1), (2, -2, 0)))),
    )


def _products(a, b, v, t):
    constant = np.arange(35.0).reshape(5, 7)
    return (
        (a @ b, a @ v, v @ a.T, v @ v, constant @ v, v[:5] @ constant, jnp.outer(v, v)),
        (jnp.einsum("bij,bkj->bik", t, t), jnp.tensordot(t, t, [[0, 2], [0, 2]])),
        jnp.einsum("bij,jk->bik", t, jnp.ones((4, 2)) * jnp.arange(2)),
    )


def _solutions(s, v):
    solve = jax.scipy.linalg.solve_triangular
    return (
        (jnp.linalg.solve(s, v[:6]), jnp.linalg.inv(s), jnp.linalg.det(s)),
        (solve(s, v[:6], lower=True), solve(s, v[:6], trans=1)),
        lax.linalg.triangular_solve(s, s[:3], left_side=False, lower=True, unit_diagonal=True),
        jax.vmap(jnp.linalg.inv)(jnp.stack([s, s.T])),
        (jnp.linalg.det(0 * s), jnp.linalg.slogdet(s.at[:, 2].set(0.0))),  # zero pivots
    )


def _reductions(a, t):
    return (
        (a.sum(), a.max(axis=0), t.min(axis=(0, 2)), a.prod(), (a > 0).all(axis=1), (a > 0).any()),
        (jnp.argmax(a, axis=1), jnp.argmin(a), jnp.cumsum(a, axis=1), lax.cumsum(a, axis=0, reverse=True)),
        (jnp.sort(a[0]), jnp.argsort(a[1]), jnp.where(a > 0, a, jnp.nan).max()),
    )


def _whole_and_logical(i, a):
    low, big = jnp.arange(3) - 2**40 * i, jnp.arange(3, dtype=jnp.uint32) + i.astype(jnp.uint32)
    return (
        ((a > 9).max(), (a > 0).min(axis=0), jnp.max(low), jnp.min(-low), jnp.max(big), jnp.min(big)),
        (lax.reduce_and_p.bind(low, axes=(0,)), lax.reduce_or_p.bind(low, axes=(0,)), lax.cummax(low)),
        (
            low**3 % 5,
            jnp.take(low, i + 9),
            jnp.take(big, i + 9),
            low[lax.clamp(0, i, 1)],
        ),
        (i.astype(jnp.int16) * jnp.int16(3)) % jnp.int16(4),
    )


def _places(a, v, t, i):
    return (
        (
            a[np.array([0, 2, 4])],
            v[np.array([[1, 2], [0, 6]])],
            a[:, np.array([1, 3])],
            t[1, np.array([0, 2])],
        ),
        (a.at[1:3].multiply(2.0), a.at[np.array([0, 0, 1])].add(1.0), a.at[2, 3].set(v[0])),
        jnp.ones(5).at[jnp.array([i, i + 5])].get(mode="fill", fill_value=3.0) * v[0],
        (a[i], a[i, i + 1], v[jnp.array([i, i + 1, 9])], a.at[i].add(v), a.at[i + 9].set(v)),
        (lax.dynamic_slice(a, (i, 1), (2, 3)), lax.dynamic_update_slice(a, v[None, :3], (i, i))),
        (jnp.searchsorted(jnp.arange(7.0), v[0]), v.at[i].max(9.0), a.at[jnp.array([i, 9])].add(1.0)),
    )


def _loops(a, v, i):
    return (
        lax.while_loop(
            lambda c: c[0].sum() < 50, lambda c: (c[1] * 1.5, c[0] + 1.0, c[2]), (v * v, v * v, a)
        ),
        lax.cond(i > 1, lambda: (v * 2, a), lambda: (v, a * 3)),
        lax.switch(i, [lambda: v, lambda: v * 2, lambda: v * 3, lambda: v]),
        lax.fori_loop(0, 5, lambda k, m: m.at[k].add(a[k, 0] * m[k + 1]), v),
        lax.fori_loop(0, 3, lambda _, c: (c[1], c[0], c[2] + c[0]), (v, v * 2, v)),  # values change places
        lax.scan(lambda c, x: (c + x, c * x.sum()), v, a),
        lax.scan(lambda c, x: (c + x, c[:2]), v, a, reverse=True),
        jax.jacfwd(lambda x: jnp.sin(x @ x.T).sum(0))(a),
    )


def _storage(a, v):
    """Two arrays that only loops read; the second one is computed before the first one is read."""
    first, second = jnp.cumsum(jnp.sin(a), axis=1), jnp.cumsum(jnp.cos(a), axis=1)

    def added(rows, start):
        def step(c, k):
            longer = jnp.cumsum(jnp.sort(c + rows[k] * c.sum()))
            return jnp.sort(jnp.sin(longer)) * jnp.cumsum(longer)[::-1], rows[k].sum() * c

        return lax.scan(step, start, jnp.arange(5))

    end, found = added(second, v)
    return added(first, end), found


CASES = {
    _elementwise: (A, B, SCALAR),
    _shapes: (A, B, T, SCALAR),
    _products: (A, B, V, T),
    _solutions: (S, V),
    _reductions: (A, T),
    _whole_and_logical: (TWO, A),
    _places: (A, V, T, TWO),
    _loops: (A, V, TWO),
    _storage: (A, V),
}


@needs_compiler
@pytest.mark.parametrize("function", CASES, ids=lambda each: each.__name__.strip("_"))
def test_a_family_gives_the_numbers_of_jax(function, tmp_path):
    check(function, tmp_path)


@needs_compiler
@pytest.mark.parametrize(
    "function",
    [
        _loops,
        _storage,
        *(pytest.param(each, marks=pytest.mark.slow) for each in CASES if each not in (_loops, _storage)),
    ],
)
def test_long_functions_in_parts_give_the_same(function, tmp_path, monkeypatch):
    monkeypatch.setattr(blocks, "LONGEST", 12)
    monkeypatch.setattr(separate_functions, "_LINES", 4)
    check(function, tmp_path)


def check(function, tmp_path):
    """Compare each result of a function in C with that of JAX."""
    expected = jax.tree.leaves(jax.jit(function)(*CASES[function]))
    for number, (own, exact) in enumerate(
        zip(by_c(tmp_path, function, *CASES[function]), expected, strict=True)
    ):
        np.testing.assert_allclose(own, exact, rtol=1e-12, atol=1e-13, err_msg=str(number))


@needs_compiler
def test_constants_stand_in_tables_once(tmp_path):
    table = np.arange(6.0)
    source = function_source(lambda x: (x + table, x * jnp.asarray(table)), np.ones(6))
    assert source.count("static const double") == 1
    for own, exact in zip(
        by_c(tmp_path, lambda x: (x + table, x * table), np.ones(6)), (1 + table, table), strict=True
    ):
        np.testing.assert_array_equal(own, exact)


def test_an_operation_without_a_form_is_named():
    with pytest.raises(ModelError, match="'fft'"):
        function_source(lambda x: jnp.fft.fft(x).real, np.ones(8))
