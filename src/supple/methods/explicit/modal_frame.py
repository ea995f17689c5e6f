"""A modal sub-domain with the mass tied to it: modes for the whole mass, step limit, contacts."""

from __future__ import annotations

from dataclasses import dataclass

import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray
from scipy import linalg, sparse

from supple.arrays import FloatArray
from supple.methods.explicit.frame_model import FrameModel
from supple.methods.explicit.frame_moments import Moments, moments
from supple.methods.explicit.mass_fields import MassFields
from supple.methods.explicit.modal_subdomain import ModalSubdomain
from supple.methods.explicit.rigid_frame import RigidFrame
from supple.methods.explicit.spin_stiffness import largest_of_unit_spin
from supple.methods.explicit.step_limit import (
    damped_limit,
    free_modal_mass,
    local_mass,
    mass_of_motions,
    true_limit,
)


@dataclass(frozen=True, eq=False)
class ModalFrame:
    """A modal sub-domain in the time integration.

    turned : (k, k)     modes of the sub-domain per integrated mode: y_own = turned @ y
    """

    body: ModalSubdomain | RigidFrame
    model: FrameModel
    turned: FloatArray

    @property
    def shapes(self) -> FloatArray:
        """(N, 3, k) shapes of the integrated modes, in units of the arm."""
        return self.body.shapes @ self.turned

    def weights(self, nodes: NDArray[np.int64]) -> FloatArray:
        """(n, 4) weights of nodes on the four points."""
        return self.body.points.weights(self.body.nodes[nodes])

    def step_limit(self, penalty: FloatArray | None = None) -> float:
        """Longest stable step, s; penalty : (6 + k, 6 + k) stiffness of all contacts, assumed closed."""
        if penalty is None:
            limit = true_limit(self.model.moments, self.body.points, np.asarray(self.model.stiffness))
        else:
            mass, stiffness = self.pencil()
            largest = linalg.eigh(stiffness + penalty, mass, eigvals_only=True)[-1]
            limit = float(2 / np.sqrt(largest))
        return damped_limit(limit, self.body.stiffness_damping)

    @property
    def spin_bound(self) -> float | None:
        """Bound of the increase of squared frequencies at 1 rad/s, 1/s^2 per (rad/s)^2, or None."""
        if self.model.spin_stiffness is None:
            return None
        mass, _ = self.pencil()
        return largest_of_unit_spin(np.asarray(self.model.spin_stiffness), free_modal_mass(mass))

    def penalty_stiffness(self, nodes: NDArray[np.int64], stiffness: FloatArray) -> FloatArray:
        """Stiffness sum s B^T B, (6 + k, 6 + k), of springs s (n,) at nodes, equal in all directions."""
        B = self.motion(nodes)
        return np.einsum("n,nia,nib->ab", stiffness, B, B, optimize=True)

    def stiffness_at(self, nodes: NDArray[np.int64], fraction: float) -> FloatArray:
        """Contact stiffness (n,), N/m, at nodes.

        It is `fraction` times the stiffness with which a node alone has the highest frequency of the modes.
        """
        mass, stiffness = self.pencil()
        largest = linalg.eigh(stiffness, mass, eigvals_only=True)[-1]
        B = self.motion(nodes)
        mobility = B @ np.linalg.solve(mass, B.swapaxes(1, 2))
        return fraction * largest / np.linalg.eigvalsh(mobility)[:, -1]

    def motion(self, nodes: NDArray[np.int64]) -> FloatArray:
        """(n, 3, 6 + k): motion of nodes of the undeformed part per rigid motion and mode, mesh axes."""
        return self.material_motion(self.weights(nodes), self.shapes[nodes])

    def material_motion(self, weights: FloatArray, shapes: FloatArray) -> FloatArray:
        """(n, 3, 6 + k): motion of material points of weights (n, 4) and shapes (n, 3, k)."""
        on_points = np.einsum("na,aic->nic", weights, self.body.points.rigid_rates)
        return np.concatenate([on_points, self.body.points.arm * shapes], axis=2)

    def pencil(self) -> tuple[FloatArray, FloatArray]:
        """Mass and stiffness (6 + k, 6 + k) of rigid motion and modes."""
        M = mass_of_motions(self.model.moments, self.body.points)
        K = np.zeros_like(M)
        K[6:, 6:] = np.asarray(self.model.stiffness)
        return M, K


def modal_frame(
    body: ModalSubdomain | RigidFrame, points: FloatArray, shapes: FloatArray, mass: FloatArray
) -> ModalFrame:
    """The frame of a sub-domain with tied points that have mass.

        K T = (M_V + sum m Phi^T Phi) T diag(omega^2),   T^T (..) T = I

    points : (n, 3) undeformed, in the mesh axes;   shapes : (n, 3, k);   mass : (n,) kg
    """
    frame = body.points
    tied = MassFields(frame.weights(points), shapes, sparse.csr_array(sparse.diags_array(mass)))
    sums = body.moments + moments(tied) if len(mass) else body.moments
    K = np.diag(body.frequencies**2)
    squares, T = (
        linalg.eigh(K, local_mass(sums, frame.arm)) if body.n_modes else (np.zeros(0), np.zeros((0, 0)))
    )
    turned = Moments(
        sums.S0,
        sums.S1 @ jnp.asarray(T),
        jnp.einsum("ijkl,ka,lb->ijab", sums.C, jnp.asarray(T), jnp.asarray(T)),
    )
    model = FrameModel(
        turned,
        jnp.diag(jnp.asarray(squares)),
        jnp.asarray(frame.squared_lengths),
        jnp.asarray(body.mass_damping),
        jnp.asarray(body.stiffness_damping),
        None if body.spin_stiffness is None else jnp.asarray(T.T @ body.spin_stiffness @ T),
    )
    return ModalFrame(body, model, T)
