"""Bodies made of finite elements."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from supple.arguments import check_instance, check_members, check_sequence, check_text
from supple.body.flexible_body import FlexibleBody
from supple.body.free_body import free_body
from supple.body.interface import AveragingInterface, RigidInterface

if TYPE_CHECKING:
    from supple.fem import FiniteElementModel

__all__ = ["flexible_body"]


def flexible_body(
    name: str,
    model: FiniteElementModel,
    interfaces: Sequence[RigidInterface | AveragingInterface] = (),
) -> FlexibleBody:
    """A body made of finite elements.

    Parameters
    ----------
    model      : elements, mass and stiffness of the body, without supports
    interfaces : points at which joints and loads act, each with its nodes: numbers, or a node set of the mesh
    Raises
    ------
    MeshError    a node set that the mesh does not have
    ModelError   a mass or stiffness matrix that is not finite or not symmetric; a mass matrix with negative
                 eigenvalues; a motion with neither mass nor stiffness; a stiffness that resists rigid motion,
                 or leaves more than six motions free; an interface without nodes, or whose nodes cannot carry
                 a rotation; two interfaces of one name; a node in two rigid interfaces
    """
    from supple.fem import nodal_rotation_operator

    check_text("flexible_body, name", name)
    check_members(
        f"flexible_body '{name}', model",
        model,
        ("mesh", "stiffness", "mass"),
        "shell_model(..) or solid_model(..)",
    )
    check_sequence(f"flexible_body '{name}', interfaces", interfaces, "a list of interfaces")
    for each in interfaces:
        expected = "RigidInterface(name, nodes) or AveragingInterface(name, nodes)"
        check_instance(
            f"flexible_body '{name}', interfaces", each, (RigidInterface, AveragingInterface), expected
        )
    rotations = nodal_rotation_operator(model)
    return free_body(
        name,
        model.mesh.nodes,
        model.stiffness,
        model.mass,
        dofs_per_node=model.dofs_per_node,
        nodal_damping=model.attached.damping,
        interfaces=tuple(
            replace(given, nodes=model.mesh.nodes_of(given.nodes)) if isinstance(given.nodes, str) else given
            for given in interfaces
        ),
        model=model,
        rotation_operator=rotations if rotations.nnz else None,
        rotation_limit=model.rotation_limit,
    )
