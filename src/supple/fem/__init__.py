"""Finite elements as quadratic-strain arrays: materials, one element per module, mass, assembly, stress."""

from supple.fem.assembly import Assembly, StrainWorks, assemble, assemble_strains
from supple.fem.beam_section import BeamSection
from supple.fem.mass import CellMass
from supple.fem.material import Isotropic
from supple.fem.model import (
    FiniteElementModel,
    cell_masses,
    lumped_mass,
    part_of_model,
    shell_model,
    solid_model,
)
from supple.fem.nodal_rotation import nodal_rotation_operator
from supple.fem.quadratic_strain import QuadraticStrain
from supple.fem.section import Section
from supple.fem.shell_kinematics import GREEN_LAGRANGE, VON_KARMAN, ShellKinematics
from supple.fem.shell_section import HomogeneousSection, LaminateSection, ShellSection
from supple.fem.stress import (
    StressRecovery,
    has_stress,
    strain_recovery,
    stress_recovery,
    von_mises,
    von_mises_strain,
)

__all__ = [
    "GREEN_LAGRANGE",
    "VON_KARMAN",
    "Assembly",
    "BeamSection",
    "CellMass",
    "FiniteElementModel",
    "HomogeneousSection",
    "Isotropic",
    "LaminateSection",
    "QuadraticStrain",
    "Section",
    "ShellKinematics",
    "ShellSection",
    "StrainWorks",
    "StressRecovery",
    "assemble",
    "assemble_strains",
    "cell_masses",
    "has_stress",
    "lumped_mass",
    "nodal_rotation_operator",
    "part_of_model",
    "shell_model",
    "solid_model",
    "strain_recovery",
    "stress_recovery",
    "von_mises",
    "von_mises_strain",
]
