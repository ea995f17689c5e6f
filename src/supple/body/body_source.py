"""Sources of elastic bodies: elements or matrices, each read and assembled once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np

from supple.arrays import IntArray
from supple.body.deck_body import deck_connections, deck_mesh, deck_model, refuse_omitted_cards
from supple.body.deck_parts import named_part
from supple.body.finite_element_body import flexible_body
from supple.body.flexible_body import FlexibleBody
from supple.body.interface import AveragingInterface, RigidInterface
from supple.body.labelled_superelement import (
    MatrixFiles,
    NodalMatrices,
    labelled_superelement,
    read_nodal_matrices,
)
from supple.body.model_check import ModelCheck, check_elements, check_model, check_nodal_matrices
from supple.body.section_beams import section_beams
from supple.body.superelement import read_superelement
from supple.errors import ModelError
from supple.fem import GREEN_LAGRANGE, FiniteElementModel, ShellKinematics
from supple.importers import Connection, positions_of_ids, read_deck, read_matrix, read_section_table
from supple.mesh import Mesh

__all__ = [
    "BodySource",
    "deck_source",
    "elements_source",
    "labelled_matrices_source",
    "matrices_source",
    "section_beams_source",
]


@dataclass(frozen=True, eq=False)
class BodySource:
    """Functions that give an elastic body, its check and its data.

    check : from the number of elastic modes to the check of the nodal matrices without interfaces
    body : from a name and interfaces to the body; ModelError for errors of the model
    connections : RBE2 and RBE3 elements that can be interfaces
    numbers : from node ids of the body's file to node numbers
    mesh, model : mesh, and function for the finite-element model; None for a body from matrices
    ties_itself : whether rigid connections are constraints even if no interface uses them
    """

    check: Callable[[int], ModelCheck]
    body: Callable[[str, Sequence[RigidInterface | AveragingInterface]], FlexibleBody]
    connections: Callable[[], Sequence[Connection]] = tuple
    numbers: Callable[[IntArray], IntArray] = np.asarray
    mesh: Mesh | None = None
    model: Callable[[], FiniteElementModel] | None = None
    ties_itself: bool = False


def elements_source(
    mesh: Mesh, assemble: Callable[[], FiniteElementModel], connections: Sequence[Connection] = ()
) -> BodySource:
    """Source of a body of finite elements.

    assemble : returns the finite-element model of the mesh; called once, on first use
    connections : RBE2 and RBE3 elements of the mesh file
    """
    model = cache(assemble)
    return BodySource(
        lambda n_frequencies: check_elements(model(), n_frequencies=n_frequencies),
        lambda name, interfaces: flexible_body(name, model(), interfaces),
        lambda: connections,
        mesh.numbers_of,
        mesh,
        model,
    )


def deck_source(
    path: Path,
    kinematics: ShellKinematics = GREEN_LAGRANGE,
    *,
    part: str | None = None,
    leave_out: Sequence[str] = (),
) -> BodySource:
    """Source of the body of a deck, whose rigid ties are constraints even if no interface uses them.

    part : as for `named_part`;  leave_out : as for `refuse_omitted_cards`
    Raises ImportFormatError for a file that cannot be read; ModelError as for `named_part`; omitted cards
    that `leave_out` does not allow.
    """
    deck = read_deck(path)
    refuse_omitted_cards(deck, leave_out)
    own = named_part(deck, part)
    made = elements_source(
        deck_mesh(own), lambda: deck_model(own, kinematics=kinematics), deck_connections(own)
    )
    return replace(made, ties_itself=True)


def section_beams_source(path: Path) -> BodySource:
    """Source of a chain of beams between the sections of a table; errors as for `read_section_table`."""
    model = section_beams(read_section_table(path))
    return elements_source(model.mesh, lambda: model)


def labelled_matrices_source(files: MatrixFiles, *, rigid_tolerance: float | None = None) -> BodySource:
    """Source of a body from matrix files of another program, as for `read_labelled_superelement`.

    The matrices may come from any element type, so the elements of the node file are not used.
    rigid_tolerance : as for `superelement`; None: from the printed precision of the matrices
    """

    @cache
    def read() -> NodalMatrices:
        return read_nodal_matrices(files)

    exact = rigid_tolerance
    return BodySource(
        lambda n: check_nodal_matrices(read(), n_frequencies=n, rigid_tolerance=exact),
        lambda name, interfaces: labelled_superelement(name, read(), interfaces, rigid_tolerance=exact),
        lambda: read().connections,
        lambda ids: _numbers(read().all_ids, ids),
    )


def _numbers(ids: IntArray, wanted: IntArray) -> IntArray:
    number, known = positions_of_ids(ids, wanted)
    if not known.all():
        lost = np.asarray(wanted)[~known][0]
        raise ModelError(
            f"no node of the matrices has the id {lost}; use ids from {ids.min()} to {ids.max()}"
        )
    return number


def matrices_source(
    *,
    nodes: Path,
    stiffness: Path,
    mass: Path,
    dofs_per_node: int,
    damping: Path | None = None,
    recovery: Path | None = None,
    points: Path | None = None,
) -> BodySource:
    """Source of a body from Matrix Market files, as for `read_superelement`."""

    def check(n_frequencies: int) -> ModelCheck:
        return check_model(
            read_matrix(nodes).toarray(),
            read_matrix(stiffness),
            read_matrix(mass),
            dofs_per_node=dofs_per_node,
            n_frequencies=n_frequencies,
        )

    return BodySource(
        check,
        lambda name, interfaces: read_superelement(
            name,
            nodes=nodes,
            stiffness=stiffness,
            mass=mass,
            dofs_per_node=dofs_per_node,
            damping=damping,
            interfaces=interfaces,
            recovery=recovery,
            points=points,
        ),
    )
