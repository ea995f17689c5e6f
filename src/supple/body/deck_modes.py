"""Mass and natural frequencies of a deck with all its parts, free or with its own supports."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np

from supple.algebra import lowest_modes
from supple.arrays import FloatArray
from supple.body.coordinates import coordinates, rigid_sets
from supple.body.deck_body import deck_model
from supple.body.deck_parts import deck_parts, with_scalar_points, without_scalar_points
from supple.body.free_body import RIGID_TOLERANCE
from supple.body.mass_properties import MassProperties, rigid_mass_properties
from supple.body.model_check import ZERO_MODE
from supple.errors import SuppleWarning
from supple.fem import FiniteElementModel
from supple.importers.deck import Deck

__all__ = ["deck_frequencies", "deck_mass", "deck_models", "mass_of_models"]

MORE_MODES = 6
"""Number of modes computed in addition to the n wanted modes and six rigid modes of a free part.

A part with more than this number of mechanisms gives fewer than n frequencies.
"""


def deck_models(deck: Deck, *, held: bool = False) -> dict[str, FiniteElementModel]:
    """Finite-element models of the parts of a deck, by part name (`deck_parts`), largest first.

    held : as for `deck_model`; True also gives scalar points a node
    Errors as for `deck_model`, whose warnings are suppressed.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SuppleWarning)
        whole = with_scalar_points(deck) if held else deck
        return {name: deck_model(part, held=held) for name, part in deck_parts(whole).items()}


def mass_of_models(models: Sequence[FiniteElementModel]) -> MassProperties:
    """Mass, centre of mass, and inertia about the centre of mass, of several models together."""
    own = [rigid_mass_properties(each.mass, each.mesh.nodes, each.dofs_per_node) for each in models]
    total = sum(each.mass for each in own)
    centre = sum((each.mass * each.centre for each in own), np.zeros(3)) / (total or 1.0)
    inertia = np.zeros((3, 3))
    for each in own:
        arm = each.centre - centre
        inertia += each.inertia + each.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return MassProperties(float(total), centre, inertia)


def deck_mass(deck: Deck) -> MassProperties:
    """Mass properties of all parts of a deck together, without scalar points; errors as for `deck_model`."""
    return mass_of_models(list(deck_models(without_scalar_points(deck), held=True).values()))


def deck_frequencies(deck: Deck, n: int, *, held: bool = False) -> FloatArray:
    """At most n lowest natural frequencies of all parts, cycles per unit of time, ascending.

    held : True: frequencies of all modes with the deck's supports, including remaining rigid motions; False:
        frequencies of the elastic modes without supports
    Parts without mass are omitted.

    Raises ModelError, MeshError as for `deck_model`; parts whose massless freedoms cannot be condensed.
    """
    found = [np.zeros(0)]
    for model in deck_models(deck, held=held).values():
        if model.mass.nnz and model.mass.diagonal().max() > 0:
            found.append(_frequencies(model, n, held=held))
    return np.sort(np.concatenate(found))[:n]


def _frequencies(model: FiniteElementModel, n: int, *, held: bool) -> FloatArray:
    sets = rigid_sets("deck", model.mesh.n_nodes, (), model.attached)
    made = coordinates(
        *("deck", model.mesh.nodes, model.dofs_per_node, model.stiffness, model.mass, sets, model.attached),
        tolerance=RIGID_TOLERANCE,
        held=held,
        node_ids=model.mesh.node_ids,
    )
    if not len(made.freedoms):
        return np.zeros(0)
    if abs(made.stiffness).max() <= RIGID_TOLERANCE * abs(model.stiffness).max():  # a rigid part
        return np.zeros(min(n, len(made.freedoms)) if held else 0)
    wanted = min(n if held else n + 6 + MORE_MODES, len(made.freedoms))
    values = lowest_modes(made.stiffness, made.mass, wanted).values
    if not held and len(values):
        values = values[values > ZERO_MODE * values[-1]]
    return np.sqrt(np.maximum(values, 0.0)) / (2 * np.pi)
