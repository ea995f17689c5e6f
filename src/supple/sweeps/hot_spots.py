"""Fatigue damage at nodes of a reduced body, a channel per node: `[[output.fatigue.hot_spot]]`."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Annotated, NamedTuple

import numpy as np
from pydantic import Field

from supple.arrays import FloatArray
from supple.cases.case import Case
from supple.cases.table import Key, Made, OneOf, table_of
from supple.errors import CaseError, SuppleError, did_you_mean
from supple.fatigue import Goodman, Residue, SNCurve, ThicknessEffect
from supple.fem import FiniteElementModel
from supple.importers.toml import CheckedTable, Positive
from supple.integrate import FloatingMotion, Solution
from supple.machine import System
from supple.quantities import CriticalPlane, SignedVonMises, hot_spot_damage, stress_modes
from supple.quantities.tensor_modes import TensorModes
from supple.reduction import ReducedBody
from supple.sweeps.group_bodies import is_reduced_here

MOST_NODES = 1000
"""Largest number of nodes of a hot spot; each is a channel of every case."""


Thickness = table_of(ThicknessEffect)
_THICKNESS = Key(Thickness | None, "{ thickness, reference, exponent } of the plate", default=None)
Planes = table_of(CriticalPlane, "critical-plane")
Signed = table_of(SignedVonMises, "signed-von-mises")


class HotSpotCurve(table_of(SNCurve, thickness=_THICKNESS)):
    """Table of an S-N curve."""


class HotSpot(CheckedTable):
    """Table of nodes whose damage is computed from the stress modes of their body."""

    name: str = Field(min_length=1, description="name of the hot spot; its channels are NAME.NODE")
    nodes: str = Field(description="BODY.NODE_SET of a body that the sweep reduces")
    curve: HotSpotCurve = Field(
        description="{ reference_range, reference_cycles, exponent, .. } in units of stress"
    )
    criterion: Annotated[Made, OneOf(Planes, Signed)] = Field(
        default_factory=lambda: Planes(kind="critical-plane"),
        description='{ kind = "critical-plane" } or { kind = "signed-von-mises" }',
    )
    ultimate: Positive | None = Field(
        None, description="ultimate stress for Goodman's correction; default: no correction"
    )

    @property
    def body(self) -> str:
        """Name of the body."""
        return self.nodes.partition(".")[0]

    def numbers(self, case: Case) -> tuple[int, ...]:
        """Indices of the nodes in the mesh of the body."""
        return tuple(case.meshes[self.body].nodes_of(self.nodes.partition(".")[2]).tolist())


class NodalDamage(NamedTuple):
    """Damage of a case at the k nodes of all hot spots."""

    names: tuple[str, ...]
    places: tuple[str, ...]
    damage: FloatArray


def check_hot_spots(spots: Sequence[HotSpot], case: Case) -> None:
    """CaseError for equal names, an unknown or large node set, or a body that the sweep does not reduce."""
    reduced = [table.name for table in case.parts.body if is_reduced_here(table)]
    names = [spot.name for spot in spots]
    for spot in spots:
        at = f"hot spot '{spot.name}'"
        if names.count(spot.name) > 1:
            raise CaseError(f"{at} is given twice; give each its own name")
        if spot.body not in reduced:
            raise CaseError(
                f"{at}: this case has no body {spot.body!r} that is reduced from its elements"
                + did_you_mean(spot.body, reduced)
            )
        try:
            nodes = spot.numbers(case)
        except SuppleError as error:
            raise CaseError(f"{at}: {error}") from error
        if len(nodes) > MOST_NODES:
            raise CaseError(
                f"{at} has {len(nodes)} nodes, each a channel; choose a set of at most {MOST_NODES}"
            )


def damage_of_hot_spots(
    spots: Sequence[HotSpot], residue: Residue, case: Case, system: System, solution: Solution
) -> NodalDamage:
    """Damage at the nodes of hot spots over a run; errors as for `hot_spot_damage`."""
    names, places, damages = list[str](), list[str](), [np.zeros(0)]
    for spot in spots:
        nodes = spot.numbers(case)
        modes = _modes(system.bodies_of(ReducedBody)[spot.body], case.elements[spot.body], nodes)
        correction = None if spot.ultimate is None else Goodman(spot.ultimate)
        ids = case.meshes[spot.body].node_ids[list(nodes)].tolist()
        names += [f"{spot.name}.{number}" for number in ids]
        places += [f"node {number} of {spot.body}" for number in ids]
        damages.append(
            hot_spot_damage(
                modes,
                solution.motion(spot.body, FloatingMotion).coordinates,
                spot.curve.build(),
                spot.criterion.build(),
                residue=residue,
                correction=correction,
            )
        )
    return NodalDamage(tuple(names), tuple(places), np.concatenate(damages))


@lru_cache(maxsize=8)
def _modes(body: ReducedBody, model: FiniteElementModel, nodes: tuple[int, ...]) -> TensorModes:
    """Stress modes at the nodes, cached because the cases of a group share the body."""
    return stress_modes(body, model, nodes)
