"""Finite rotations in JAX: products, skew matrix, exponential, right Jacobian, logarithm, Euler parameters.

A rotation `A` maps body components to global ones. Variations are on the right, in body components:
`dA = A skew(dpsi)`. All functions are smooth at zero, so that they can be differentiated there.

JAX traces each function once for all its uses (`jax.jit`): tracing takes half a millisecond per operation,
and a machine has thousands of operations.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np

import supple.algebra.jax_settings  # noqa: F401 - 64-bit floats, before the first array

# Below this squared angle the trigonometric quotients are replaced by their series (error < 1e-17).
_SMALL_SQUARED_ANGLE = 1e-2


@jax.jit
def small_product(a: jax.Array, b: jax.Array) -> jax.Array:
    """`a @ b` for a (..., m) and b (m, n) or (m,), m small, as a part of the surrounding loop.

    XLA calls a library for every `@`: for 3 x 3 matrices the call costs many times the arithmetic. Written as
    a sum, the product becomes part of the loop around it.
    """
    if b.ndim == 1:
        return (a * b).sum(axis=-1)
    return (a[..., None] * b).sum(axis=-2)


@jax.jit
def skew(v: jax.Array) -> jax.Array:
    """Matrix of the cross product, `skew(v) @ w = v x w`; shape (3,) to (3, 3)."""
    x, y, z = v[0], v[1], v[2]
    zero = jnp.zeros_like(x)
    return jnp.stack([zero, -z, y, z, zero, -x, -y, x, zero]).reshape(3, 3)


@jax.jit
def unskew(matrix: jax.Array) -> jax.Array:
    """Axial vector of the skew part of a 3 x 3 matrix; equals `sin(angle) axis` for a rotation matrix."""
    return 0.5 * jnp.stack(
        [matrix[2, 1] - matrix[1, 2], matrix[0, 2] - matrix[2, 0], matrix[1, 0] - matrix[0, 1]]
    )


# Factors of the nested series `1/k! (1 - s/a_1 (1 - s/a_2 (...)))` of the three quotients below, by column.
_SERIES = np.array(
    [
        [1, 1 / 2, 1 / 6],
        [1 / 6, 1 / 12, 1 / 20],
        [1 / 20, 1 / 30, 1 / 42],
        [1 / 42, 1 / 56, 1 / 72],
        [1 / 72, 1 / 90, 1 / 110],
        [1 / 110, 1 / 132, 1 / 156],
    ]
)


@jax.jit
def angle_quotients(squared: jax.Array) -> jax.Array:
    """`sin x / x`, `(1 - cos x) / x^2`, `(x - sin x) / x^3` as smooth functions of `x^2` (...), (3, ...)."""
    small = squared < _SMALL_SQUARED_ANGLE
    s = jnp.where(small, squared, 0.0)
    first, *middle, last = _SERIES.reshape(*_SERIES.shape, *(1,) * squared.ndim)
    series = 1 - last * s
    for factors in reversed(middle):
        series = 1 - factors * s * series
    # `where` evaluates both branches: keep the closed form away from 0 / 0, whose derivative is NaN.
    safe = jnp.where(small, 1.0, squared)
    x = jnp.sqrt(safe)
    sin, cos = jnp.sin(x), jnp.cos(x)
    closed = jnp.stack([sin, 1 - cos, x - sin]) / jnp.stack([x, safe, safe * x])
    return jnp.where(small, first * series, closed)


@jax.jit
def rotation_exp(psi: jax.Array) -> jax.Array:
    """Rotation matrix of a rotation vector (Rodrigues): `exp(skew(psi))`; shape (3,) to (3, 3)."""
    sinc, versine, _ = angle_quotients(psi @ psi)
    matrix = skew(psi)
    return jnp.eye(3) + sinc * matrix + versine * (jnp.outer(psi, psi) - (psi @ psi) * jnp.eye(3))


@jax.jit
def rotation_right_jacobian(psi: jax.Array) -> jax.Array:
    """Matrix `T(psi)` with `exp(psi)^T d exp(psi) = skew(T dpsi)`; shape (3,) to (3, 3)."""
    _, versine, cubic = angle_quotients(psi @ psi)
    matrix = skew(psi)
    return jnp.eye(3) - versine * matrix + cubic * (jnp.outer(psi, psi) - (psi @ psi) * jnp.eye(3))


@jax.jit
def right_jacobian_slope(psi: jax.Array, vector: jax.Array) -> tuple[jax.Array, jax.Array]:
    """`T(psi)^T vector` (3,), and its derivative with respect to `psi`, (3, 3)."""
    square = psi @ psi
    (_, versine, cubic), (_, versine_slope, cubic_slope) = jax.jvp(
        angle_quotients, (square,), (jnp.ones_like(square),)
    )
    along, across = psi @ vector, jnp.cross(psi, vector)
    bent = along * psi - square * vector
    derivative = (
        jnp.outer(versine_slope * across + cubic_slope * bent - cubic * vector, 2 * psi)
        + cubic * (jnp.outer(psi, vector) + along * jnp.eye(3))
        - versine * skew(vector)
    )
    return vector + versine * across + cubic * bent, derivative


@jax.jit
def euler_parameters(rotation: jax.Array) -> jax.Array:
    """Unit quaternion `(e0, e1, e2, e3)`, `e0 >= 0`, of a rotation matrix; shape (3, 3) to (4,).

    The largest of the four is found first, which avoids division by a small number [Shepperd1978].
    """
    trace = jnp.trace(rotation)
    diagonal = jnp.diagonal(rotation)
    squared = jnp.concatenate([(1 + trace)[None], 1 + 2 * diagonal - trace])
    off = 2 * unskew(rotation)
    sums = rotation + rotation.T
    rows = jnp.stack(
        [
            jnp.stack([squared[0], off[0], off[1], off[2]]),
            jnp.stack([off[0], squared[1], sums[0, 1], sums[0, 2]]),
            jnp.stack([off[1], sums[0, 1], squared[2], sums[1, 2]]),
            jnp.stack([off[2], sums[0, 2], sums[1, 2], squared[3]]),
        ]
    )
    largest = jnp.argmax(squared)
    quaternion = rows[largest] / jnp.linalg.norm(rows[largest])
    return jnp.where(quaternion[0] < 0, -quaternion, quaternion)


@jax.jit
def rotation_log(rotation: jax.Array) -> jax.Array:
    """Rotation vector of a rotation matrix, angle in [0, pi]; shape (3, 3) to (3,)."""
    quaternion = euler_parameters(rotation)
    vector = quaternion[1:]
    squared_sine = vector @ vector
    small = squared_sine < 1e-16
    sine = jnp.sqrt(jnp.where(small, 1.0, squared_sine))
    return jnp.where(small, 2.0, 2 * jnp.arctan2(sine, quaternion[0]) / sine) * vector
