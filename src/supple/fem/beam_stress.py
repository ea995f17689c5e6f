"""Section forces of beams and rods from their strains, and the stress that they cause in the section."""

from __future__ import annotations

import numpy as np

from supple.arrays import FloatArray
from supple.fem.beam2 import BeamLine
from supple.fem.beam_section import MX, MY, MZ, VY, VZ, BeamSection, LineSection, N, RodSection
from supple.fem.quadratic_strain import QuadraticStrain

FIRST, SECOND = 0, 1
XX, XZ, XY = 0, 4, 5


def end_forces(block: QuadraticStrain, length: FloatArray, section: LineSection | RodSection) -> FloatArray:
    """Matrices (E, 2, 6, s) from the strains of beams or rods to N V_y V_z M_x M_y M_z at the ends; N, N m.

    With Q = D eps, as in `chord_stiffness`:

        N = Q_1 / L,  M_x = Q_2,  M_y = Q_3 -+ Q_5 / 2,  M_z = Q_4 -+ Q_6 / 2,  V_z = Q_5 / L,  V_y = -Q_6 / L

    with - at the first end and + at the second. These are the forces of the part towards the second end on
    the part towards the first end, in the axes of the section. A rod has Q_1, and Q_2 if it resists torsion.

    length : (E,) from end to end, m
    """
    s = block.D.shape[-1]
    by_stress = np.zeros((len(length), 2, 6, s))
    by_stress[:, :, N, 0] = 1 / length[:, None]
    if s > 1:
        by_stress[:, :, MX, 1] = 1
    if not isinstance(section, RodSection):
        half = np.array([-0.5, 0.5])
        by_stress[:, :, MY, 2] = by_stress[:, :, MZ, 3] = 1
        by_stress[:, :, MY, 4] = by_stress[:, :, MZ, 5] = half
        by_stress[:, :, VZ, 4] = 1 / length[:, None]
        by_stress[:, :, VY, 5] = -1 / length[:, None]
    return by_stress @ block.D[:, None]


def has_points(section: LineSection | RodSection) -> bool:
    """Whether a section has recovery points: a rod always, a BeamSection if its geometry at each end does."""
    if isinstance(section, BeamSection):
        ends = (section, section.second or section)
        return all(end.geometry is not None and end.geometry.points for end in ends)
    return isinstance(section, RodSection)


def stress_by_forces(section: LineSection | RodSection, end: int) -> FloatArray:
    """Matrices (p, 6, 6) from the section forces N V_y V_z M_x M_y M_z to the stress at p recovery points.

        sigma = E (eps + z kappa_y - y kappa_z),   (eps, kappa) = flexibility (N, M_y, M_z)

    The matrices also contain the shear stress of torsion. Components xx yy zz yz xz xy, in the axes of the
    section. The shear stress of V_y and V_z, zero where bending stress is largest, is not included. A rod has
    one point, with the shear stress c M_x / J.

    end : FIRST or SECOND; the two differ only for a tapered beam
    """
    if isinstance(section, RodSection):
        stress = np.zeros((1, 6, 6))
        stress[0, XX, N] = 1 / section.area
        stress[0, XZ, MX] = section.torsion_arm / section.J if section.J else 0.0
        return stress
    assert isinstance(section, BeamSection)
    own = section if end == FIRST or section.second is None else section.second
    assert own.geometry is not None
    y, z = np.array(own.geometry.points).T
    strain = section.flexibility(np.array([float(end)]))[0]
    stress = np.zeros((len(y), 6, 6))
    stress[:, XX] = strain[N] + z[:, None] * strain[MY] - y[:, None] * strain[MZ]
    stress[:, XX] *= section.material.youngs_modulus
    if own.geometry.torsion_shear:
        stress[:, XY, MX], stress[:, XZ, MX] = np.array(own.geometry.torsion_shear).T
    return stress


def line_to_global(axes: FloatArray) -> FloatArray:
    """Global components (E, 6, 6) of the stress of lines from xx, xz, xy in their axes (E, 3, 3)."""
    turned = np.zeros((len(axes), 6, 6))
    x = axes[:, 0]
    for column, other, factor in ((XX, 0, 0.5), (XZ, 2, 1.0), (XY, 1, 1.0)):
        a = axes[:, other]
        full = factor * (x[:, :, None] * a[:, None] + a[:, :, None] * x[:, None])
        turned[:, :, column] = full[:, [0, 1, 2, 1, 0, 0], [0, 1, 2, 2, 2, 1]]
    return turned


def rod_line(ends: FloatArray) -> BeamLine:
    """Axes of rods with ends (E, 2, 3): x along the rod, y and z any directions normal to it."""
    chord = ends[:, 1] - ends[:, 0]
    length = np.linalg.norm(chord, axis=1)
    x = chord / length[:, None]
    aside = np.eye(3)[np.abs(x).argmin(axis=1)]
    y = np.cross(aside, x)
    y /= np.linalg.norm(y, axis=1)[:, None]
    return BeamLine(np.stack([x, y, np.cross(x, y)], axis=1), length, np.zeros_like(ends))
