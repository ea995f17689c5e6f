"""Bodies from Nastran bulk data: our elements with the properties and connections of the file."""

from __future__ import annotations

from pathlib import Path

from supple.body.connection_interfaces import connection_interface
from supple.body.finite_element_body import flexible_body
from supple.body.flexible_body import FlexibleBody
from supple.errors import ModelError
from supple.fem import (
    GREEN_LAGRANGE,
    BeamSection,
    FiniteElementModel,
    HomogeneousSection,
    Isotropic,
    ShellKinematics,
    shell_model,
    solid_model,
)
from supple.importers import (
    BeamProperty,
    ElasticMaterial,
    NastranModel,
    ShellProperty,
    SolidProperty,
    UnusedNodes,
    read_nastran,
)

__all__ = ["nastran_model", "read_nastran_body"]


def read_nastran_body(
    name: str, path: str | Path, *, unused_nodes: UnusedNodes = UnusedNodes.REFUSE
) -> FlexibleBody:
    """A body from a bulk data file; its interfaces are the RBE2 and RBE3 there, named rbe2_ID and rbe3_ID.

    Supports (SPC) are not applied: a body is free, and joints hold it.

    Raises
    ------
    ImportFormatError   as for `read_nastran`
    MeshError, ModelError   as for `nastran_model` and `flexible_body`
    """
    model = read_nastran(path, unused_nodes=unused_nodes)
    return flexible_body(
        name, nastran_model(model), [connection_interface(connection) for connection in model.connections]
    )


def nastran_model(model: NastranModel, *, kinematics: ShellKinematics = GREEN_LAGRANGE) -> FiniteElementModel:
    """Finite-element model with the materials and sections of a bulk data file.

    Raises
    ------
    ModelError   shells or beams and solids in one file; a shell thicker than the mesh
    """
    sections: dict[str, HomogeneousSection | BeamSection] = {}
    materials: dict[str, Isotropic] = {}
    for name, given in model.properties.items():
        match given:
            case ShellProperty():
                sections[name] = HomogeneousSection(_isotropic(given.material), given.thickness)
            case BeamProperty():
                sections[name] = BeamSection(
                    _isotropic(given.material),
                    given.area,
                    given.I1,
                    given.I2,
                    given.J,
                    given.K1,
                    given.K2,
                    given.orientation,
                    given.mass_per_length,
                )
            case SolidProperty():
                materials[name] = _isotropic(given.material)
    if sections and materials:
        raise ModelError(
            f"{model.path}: shells or beams ({', '.join(sections)}) and solids ({', '.join(materials)}) in "
            "one model, which our models do not join; make two bodies, joined at interfaces, or import the "
            "matrices (DMIG, OUTPUT4)"
        )
    return (
        shell_model(model.mesh, sections, kinematics=kinematics)
        if sections
        else solid_model(model.mesh, materials)
    )


def _isotropic(material: ElasticMaterial) -> Isotropic:
    return Isotropic(material.youngs_modulus, material.poissons_ratio, material.density)
