"""Classical laminate theory: stiffness and mass of a wall of plies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from supple.arrays import FloatArray
from supple.importers.deck import WallProperty

# Three Gauss points integrate a polynomial of degree 5; squares of shear flows have degree 4.
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(3)


@dataclass(frozen=True, eq=False)
class Ply:
    """A layer; its stiffnesses are in its axes, which are the axes of the wall rotated by `angle`.

    plane_stress : (3, 3) Pa, order xx, yy, xy (engineering shear)
    shear : (2, 2) transverse shear stiffness, order xz, yz, Pa; None if rigid
    density : kg/m^3;  thickness : m;  angle : rad, about the normal
    """

    plane_stress: FloatArray
    shear: FloatArray | None
    density: float
    thickness: float
    angle: float = 0.0

    def turned_stiffness(self) -> FloatArray:
        """Plane-stress stiffness (3, 3) in the axes of the wall."""
        c, s = np.cos(self.angle), np.sin(self.angle)
        # Strains of the wall to strains of the ply.
        T = np.array([[c * c, s * s, c * s], [s * s, c * c, -c * s], [-2 * c * s, 2 * c * s, c * c - s * s]])
        turned = T.T @ self.plane_stress @ T
        return 0.5 * (turned + turned.T)  # exactly symmetric, also where sums over plies cancel

    def turned_shear_compliance(self) -> FloatArray:
        """Transverse shear compliance (2, 2) in the axes of the wall; zero if rigid in shear."""
        if self.shear is None:
            return np.zeros((2, 2))
        c, s = np.cos(self.angle), np.sin(self.angle)
        T = np.array([[c, s], [-s, c]])
        return np.asarray(T.T @ np.linalg.inv(self.shear) @ T, dtype=np.float64)


def orthotropic_stiffness(
    E1: float, E2: float, E3: float, nu12: float, nu13: float, nu23: float, G12: float, G13: float, G23: float
) -> FloatArray:
    """Stiffness (6, 6) of an orthotropic material in its axes, order xx yy zz yz xz xy."""
    S = np.diag([1 / E1, 1 / E2, 1 / E3, 1 / G23, 1 / G13, 1 / G12])
    S[0, 1] = S[1, 0] = -nu12 / E1
    S[0, 2] = S[2, 0] = -nu13 / E1
    S[1, 2] = S[2, 1] = -nu23 / E2
    return np.asarray(np.linalg.inv(S), dtype=np.float64)


def plane_stress_stiffness(E1: float, E2: float, nu12: float, G12: float) -> FloatArray:
    """Plane-stress stiffness (3, 3) of an orthotropic material in its axes, order xx, yy, xy.

        Q11 = E1 / (1 - nu12 nu21),  Q12 = nu12 E2 / (1 - nu12 nu21),  Q22 = E2 / (1 - nu12 nu21),  Q66 = G12

    Source: R. M. Jones, Mechanics of Composite Materials, 2nd ed. (1999), eq. (2.70).
    """
    d = 1 - nu12**2 * E2 / E1
    return np.array([[E1 / d, nu12 * E2 / d, 0.0], [nu12 * E2 / d, E2 / d, 0.0], [0.0, 0.0, G12]])


def orthotropic_ply(
    E1: float,
    E2: float,
    nu12: float,
    G12: float,
    G13: float,
    G23: float,
    *,
    density: float,
    thickness: float,
    angle: float = 0.0,
) -> Ply:
    """Ply from engineering constants, Pa; it is rigid in transverse shear if G13 or G23 is 0."""
    shear = np.diag([G13, G23]) if G13 > 0 and G23 > 0 else None
    return Ply(plane_stress_stiffness(E1, E2, nu12, G12), shear, density, thickness, angle)


def laminate(plies: Sequence[Ply], *, bottom: float | None = None, added_mass: float = 0.0) -> WallProperty:
    """Wall of plies, listed from the bottom up.

        A, B, D = sum over plies of int Q (1, z, z^2) dz

    The transverse shear stiffness follows from equilibrium: moments that vary along the wall, M_x,x = Q_x
    and M_y,y = Q_y, cause in-plane stresses that vary, and shear stresses balance these from the bottom up,

        tau(z) = F(z) [Q_x, Q_y],   H^-1 = int F^T S F dz,   S the shear compliance of the plies.

    The shear stiffness H is 5/6 G t for a homogeneous wall. H does not depend on the position of the surface
    of the nodes.

    Parameters
    ----------
    bottom : float or None   z of the lower face from the surface of the nodes, m; None: nodes in the middle
    added_mass : float       non-structural, kg/m^2, spread over the thickness
    Source: K. Rohwer, Transverse shear stiffness of composite and sandwich finite elements, Composite
    Structures 5 (1986) 253; R. M. Jones, eq. (4.22)-(4.24).
    """
    thicknesses = np.array([ply.thickness for ply in plies])
    total = float(thicknesses.sum())
    # About the middle first, for the shear stiffness.
    faces = np.concatenate([[0.0], np.cumsum(thicknesses)]) - total / 2
    Q = np.stack([ply.turned_stiffness() for ply in plies])
    densities = np.array([ply.density for ply in plies]) + added_mass / total
    powers = [(faces[1:] ** n - faces[:-1] ** n) / n for n in (1, 2, 3)]
    A, B, D = (np.einsum("k,kij->ij", power, Q) for power in powers)
    mass, moment, rotary = (float(power @ densities) for power in powers)
    shear = _shear_stiffness(plies, Q, faces, A, B, D)
    lacks = not added_mass and any(ply.density == 0 for ply in plies)
    wall = WallProperty(A, B, D, shear, mass, rotary, total, moment, lacks)
    return wall if bottom is None else moved_wall(wall, bottom + total / 2)


def moved_wall(wall: WallProperty, offset: float) -> WallProperty:
    """The same wall, moved by `offset` along the normal from the surface of the nodes, m.

    A' = A,   B' = B + z A,   D' = D + 2 z B + z^2 A   with z = offset, and so for the moments of the mass.
    """
    A, B, D, z = wall.membrane, wall.coupling, wall.bending, offset
    mass, moment = wall.mass_per_area, wall.mass_moment_per_area
    return replace(
        wall,
        coupling=B + z * A,
        bending=D + 2 * z * B + z**2 * A,
        mass_moment_per_area=moment + z * mass,
        rotary_inertia_per_area=wall.rotary_inertia_per_area + 2 * z * moment + z**2 * mass,
    )


def _shear_stiffness(
    plies: Sequence[Ply],
    Q: FloatArray,
    faces: FloatArray,
    A: FloatArray,
    B: FloatArray,
    D: FloatArray,
) -> FloatArray | None:
    """H (2, 2); None if all plies are rigid in shear."""
    if all(ply.shear is None for ply in plies):
        return None
    # Gradients of strain and curvature (6, 2) for a unit gradient of M_x and of M_y along the wall.
    ABD = np.block([[A, B], [B, D]])
    growing = np.linalg.lstsq(ABD, np.eye(6)[:, 3:5], rcond=1e-13)[0]
    strain, curvature = growing[:3], growing[3:]
    flow = np.zeros((2, 2))  # tau at the lower face of a ply, columns Q_x and Q_y
    compliance = np.zeros((2, 2))
    pick = [0, 1]  # Q_x changes sigma_xx, which tau_xz balances; Q_y changes sigma_yy, which tau_yz balances

    def balanced(k: int, z: FloatArray) -> FloatArray:
        """-int Q (strain + z curvature) dz from the lower face of ply k, (n, 2, 2)."""
        own, linear = Q[k] @ strain, Q[k] @ curvature
        below = faces[k]
        full = (z - below)[:, None, None] * own + (z**2 - below**2)[:, None, None] / 2 * linear
        diagonal = np.zeros((len(z), 2, 2))
        diagonal[:, pick, pick] = -full[:, pick, pick]
        return diagonal

    for k, ply in enumerate(plies):
        half = ply.thickness / 2
        F = flow + balanced(k, faces[k] + half * (1 + _POINTS))
        S = ply.turned_shear_compliance()
        compliance += half * np.einsum("n,nai,ab,nbj->ij", _WEIGHTS, F, S, F)
        flow = flow + balanced(k, faces[k + 1 : k + 2])[0]
    return np.asarray(np.linalg.inv(compliance), dtype=np.float64)
