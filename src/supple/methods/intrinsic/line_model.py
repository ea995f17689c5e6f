"""Arrays of a line's equations of motion for compiled code."""

from __future__ import annotations

from dataclasses import dataclass, field

import jax
import numpy as np

import supple.algebra.jax_settings  # noqa: F401 - 64-bit floats, before the first array
from supple.arrays import AnyArray
from supple.body import Damping, ModalDamping, RayleighDamping
from supple.body.damping import refuse_relative_damping
from supple.errors import ModelError
from supple.methods.intrinsic.intrinsic_modes import IntrinsicModes


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class LineModel:
    """A line of n stations and n - 1 segments with k rigid and e elastic modes, m = k + e.

    All numbers are data: lines of equal sizes share a compiled program, and results can be differentiated.
    """

    omega: AnyArray
    """(e,) of the elastic modes, rad/s"""
    velocities: AnyArray
    """(6 n, m) Phi_1"""
    station_masses: AnyArray
    """(n, 6, 6) masses, or None where stations share mass"""
    momenta: AnyArray
    """(6 n, m) M Phi_1 where stations share mass, or None"""
    forces: AnyArray
    """(6 (n - 1), e) Phi_2"""
    strains: AnyArray
    """(6 (n - 1), e) C Phi_2"""
    twists: AnyArray
    """(6 n, 6) rigid motion by the twist of the root"""
    twist_momenta: AnyArray
    """(6 n, 6) mass matrix times that rigid motion"""
    lengths: AnyArray
    """(n - 1,) lengths of the segments"""
    directions: AnyArray
    """(n - 1, 3) directions of the segments"""
    inner: AnyArray
    """(n - 1,) station at which each segment begins"""
    ancestors: AnyArray
    """(levels, n) the ancestors 1, 2, 4, .. segments nearer the root"""
    decay: AnyArray
    """(m,) or (m, m) alpha of Rayleigh damping on velocities, 1/s"""
    retardation: AnyArray
    """(e,) or (e, e) retardation times, s: viscous force = these times multiplied by the elastic force of
    strain rates"""
    is_chain: bool = field(metadata={"static": True})

    @property
    def n(self) -> int:
        """Number of stations."""
        return self.twists.shape[0] // 6

    @property
    def n_rigid(self) -> int:
        """Number of rigid modes."""
        return self.velocities.shape[1] - self.omega.shape[0]


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class LineState:
    """State of a line at an instant.

    q1 : (m,)           amplitudes of the velocities
    q2 : (e,)           amplitudes of the internal forces and strains
    quaternion : (4,)   rotation of the root, material to global; its length has no effect
    position : (3,)     position of the root, global
    """

    q1: AnyArray
    q2: AnyArray
    quaternion: AnyArray
    position: AnyArray


def line_model(
    modes: IntrinsicModes, damping: Damping | None = None, damped: IntrinsicModes | None = None
) -> LineModel:
    """Arrays of the equations of motion for some modes of a line.

    damping : None, ModalDamping of the elastic modes, or RayleighDamping. Modal ratios and beta act on strain
        rates, at any rotation. Alpha acts on the velocities of the elastic modes.
    damped : the modes to which ratios of ModalDamping and alpha belong; default `modes`
    Raises ModelError for damping defined in a floating frame, or relative to an interface (`held`).
    """
    line, m = modes.line, modes.n_modes
    tree = line.tree
    masses = line.station_masses
    twists = line.twists
    decay, retardation = _damping(damping, modes, modes if damped is None else damped)
    return LineModel(
        omega=modes.omega[modes.n_rigid :],
        velocities=modes.velocities.reshape(-1, m),
        station_masses=masses,
        momenta=None if masses is not None else modes.momenta.reshape(-1, m),
        forces=modes.forces.reshape(-1, modes.n_elastic),
        strains=modes.strains.reshape(-1, modes.n_elastic),
        twists=twists,
        twist_momenta=line.mass @ twists,
        lengths=tree.lengths,
        directions=tree.directions,
        inner=np.asarray(tree.inner),
        ancestors=np.array(tree.ancestors, dtype=np.intp).reshape(-1, tree.n),
        decay=decay,
        retardation=retardation,
        is_chain=tree.is_chain,
    )


def _damping(
    damping: Damping | None, modes: IntrinsicModes, damped: IntrinsicModes
) -> tuple[np.ndarray, np.ndarray]:
    decay, retardation = np.zeros(modes.n_modes), np.zeros(modes.n_elastic)
    elastic = slice(modes.n_rigid, None)
    refuse_relative_damping(damping, f"line '{modes.line.name}'")
    match damping:
        case None:
            pass
        case ModalDamping():
            ratios = np.zeros(damped.n_elastic)
            ratios[: damping.n_modes] = damping.of_modes(damped.n_elastic)
            # On strain rates: damping of velocities would also resist motion without strain.
            retardation = 2 * ratios / damped.omega[damped.n_rigid :]
            if damped is not modes:
                shares = _shares(modes, damped)
                retardation = shares.T @ (retardation[:, None] * shares)
        case RayleighDamping():
            decay[elastic] = damping.alpha
            if damped is not modes:
                parts = _relative_to_root(modes, damped)
                decay = damping.alpha * parts.T @ parts
            retardation[:] = damping.beta
        case _:
            raise ModelError(
                f"line '{modes.line.name}': {type(damping).__name__} belongs to the stiffness in a floating "
                "frame, which this body does not have: use RayleighDamping, whose beta acts on strains, or "
                "ModalDamping"
            )
    return decay, retardation


def _relative_to_root(modes: IntrinsicModes, damped: IntrinsicModes) -> np.ndarray:
    """Amplitudes (e', m) of the damped modes in the motion of the modes relative to the root."""
    relative = modes.velocities.reshape(-1, modes.n_modes) - modes.line.twists @ modes.velocities[0]
    return damped.momenta.reshape(-1, damped.n_modes)[:, damped.n_rigid :].T @ relative


def _shares(modes: IntrinsicModes, damped: IntrinsicModes) -> np.ndarray:
    """Force amplitudes (e', e) in the damped modes, of unit amplitudes in the modes."""
    lengths = modes.line.tree.lengths[:, None, None]
    forces = modes.forces.reshape(-1, modes.n_elastic)
    return (lengths * damped.strains).reshape(-1, damped.n_elastic).T @ forces
