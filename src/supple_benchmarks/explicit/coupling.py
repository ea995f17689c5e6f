"""A box of two coupled halves: multipliers compared with elimination, two time steps compared with one.

The first half is modal, the second consists of elements.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from supple.fem import Isotropic, lumped_mass, solid_model
from supple.mesh import CellType, Mesh, block
from supple_benchmarks.explicit.dual_coupling import (
    CoupledMotion,
    Coupling,
    ElementSide,
    GravouilCombescure,
    ModalSide,
    MultiTimeStep,
    PrakashHjelmstad,
    dual_march,
)
from supple_benchmarks.table import Row

__all__ = ["dual_against_primal", "multi_time_steps"]

Array = NDArray[np.float64]

LIMIT = 0.5
"""Time step, s, below the stability limit 2 / omega_max of the elements; the runs use fractions of it."""


class _Halves(NamedTuple):
    coupling: Coupling
    root: NDArray[np.int64]
    mesh: Mesh
    L: Array
    K: Array
    M: Array


@cache
def _halves() -> _Halves:
    """Both halves, with the first clamped at its root, and the equations with the interface eliminated.

    The first half has 27 constraint modes and 12 fixed-interface modes, the second is a mesh of elements.
    L maps the coordinates without the interface to all modes and element freedoms; K and M belong to the
    coordinates without the interface.
    """
    mesh = block(4, 2, 2, 4, 2, 2, CellType.TETRA4)
    model = solid_model(mesh, Isotropic(1.0, 0.3, 1.0))
    K, m = model.stiffness.toarray(), lumped_mass(model)
    held, tip = (_freedoms(mesh.node_sets[name]) for name in ("root", "tip"))
    root = held
    inner = np.setdiff1d(np.arange(len(m)), np.concatenate([held, tip]))
    basis = np.zeros((len(m), 39))
    basis[tip, :27] = np.eye(27)
    basis[inner, :27] = -np.linalg.solve(K[np.ix_(inner, inner)], K[np.ix_(inner, tip)])
    basis[inner, 27:] = eigh(K[np.ix_(inner, inner)], np.diag(m[inner]))[1][:, :12]
    squares, T = eigh(basis.T @ K @ basis, basis.T @ (m[:, None] * basis))
    rows = np.zeros((27, len(m)))
    rows[np.arange(27), root] = -1
    Kj = jnp.asarray(K)
    coupling = Coupling(
        ModalSide(np.sqrt(squares), (basis @ T)[tip]), ElementSide(m, lambda u, _: -(Kj @ u), rows, K)
    )
    k, n = 39, len(m)
    free = np.setdiff1d(np.arange(n), root)
    L = np.zeros((k + n, k + len(free)))
    L[:k, :k] = np.eye(k)
    L[k + root, :k] = coupling.modal.rows
    L[k + free, k:] = np.eye(len(free))
    whole = np.zeros((k + n, k + n))
    whole[:k, :k], whole[k:, k:] = np.diag(squares), K
    masses = np.concatenate([np.ones(k), m])
    return _Halves(coupling, root, mesh, L, L.T @ whole @ L, L.T @ (masses[:, None] * L))


def _freedoms(nodes: NDArray[np.int64]) -> NDArray[np.int64]:
    return (3 * nodes[:, None] + np.arange(3)).ravel()


def _start(case: str) -> Array:
    own = _halves()
    if case == "smooth":
        return own.L @ eigh(own.K, own.M, subset_by_index=[0, 0])[1][:, 0]
    velocity = np.zeros(len(own.L))
    pulse = np.exp(-(((own.mesh.nodes[:, 0] - 3) / 0.7) ** 2))
    velocity[39 + 3 * np.arange(len(pulse))] = pulse
    velocity[39 + own.root] = 0
    return velocity


def _marched(case: str, scheme: MultiTimeStep, h: float, n: int) -> CoupledMotion:
    v = _start(case)
    zero = np.zeros_like(v)
    n_long = n // scheme.ratio
    return dual_march(
        _halves().coupling,
        scheme,
        h,
        n_long,
        modal=(zero[:39], v[:39]),
        elements=(zero[39:], v[39:]),
        every=max(1, n_long // 10),
    )


def dual_against_primal(_quick: bool) -> float:
    """Difference between the final displacements by multipliers and by elimination, for equal steps.

    The largest difference on the element side is divided by the largest displacement there.
    """
    h, n = 0.4 * LIMIT, 400
    own = _halves()
    dual = _marched("smooth", GravouilCombescure(1), h, n)
    inverse = np.linalg.inv(own.M)
    v = np.linalg.lstsq(own.L, _start("smooth"), rcond=None)[0]
    u = a = np.zeros_like(v)
    for _ in range(n):
        u = u + h * v + 0.5 * h**2 * a
        new = -inverse @ (own.K @ u)
        v, a = v + 0.5 * h * (a + new), new
    whole = (own.L @ u)[39:]
    return float(np.abs(dual.elements[-1] - whole).max() / np.abs(whole).max())


def multi_time_steps(quick: bool) -> list[Row]:
    """Two time steps compared with one: one row for each motion, scheme and ratio of the steps.

    error : largest difference of the final displacements of the elements from those with one time step, over
        the largest displacement with one time step at any output
    energy : relative change of the total energy from the start of the run to its end
    gap : largest difference of the interface velocities, `CoupledMotion.gap`
    """
    rows = []
    n = 4000 if quick else 12000
    for case in ("smooth", "pulse"):
        reference = _marched(case, GravouilCombescure(1), LIMIT / 40, n)
        for name, kind in (("gc", GravouilCombescure), ("ph", PrakashHjelmstad)):
            for ratio in (4, 10):
                motion = _marched(case, kind(ratio), LIMIT / 40, n)
                total = motion.energies.sum(axis=1)
                off = np.abs(motion.elements[-1] - reference.elements[-1]).max()
                rows.append(
                    {
                        "scheme": name,
                        "ratio": ratio,
                        "case": case,
                        "error": float(off / np.abs(reference.elements).max()),
                        "energy": float(total[-1] / total[0] - 1),
                        "gap": motion.gap,
                    }
                )
    return rows
