"""The damping of an elastic body."""

from __future__ import annotations

import warnings
from dataclasses import replace
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from supple.body import (
    FlexibleBody,
    Frame,
    LinearRayleighDamping,
    ModalDamping,
    NodalFixedFrame,
    RayleighDamping,
    rayleigh_from_ratios,
)
from supple.cases.table import Key, table_of
from supple.errors import SuppleWarning
from supple.importers.toml import CheckedTable, KeyPath, Mistakes, NonNegative, Raw, table
from supple.reduction import ReducedBody, clamped_modes

LARGEST_MISS = 0.1
"""Largest relative deviation of a clamped mode's damping ratio that causes no warning."""

HELD = "interface relative to which mass damping acts, whatever the frame; default: the body's frame"


class RayleighRatio(CheckedTable):
    """Rayleigh damping with the same damping ratio on two modes of the body, before its reduction."""

    kind: Literal["rayleigh-ratio", "linear-rayleigh-ratio"] = Field(
        description="of the strain rate, or by the stiffness of the undeformed body"
    )
    ratio: NonNegative = Field(description="damping ratio, 0.02 for 2 %")
    modes: Annotated[tuple[int, int], Field(strict=False)] = Field((1, 2), description="mode numbers from 1")
    held: str | None = Field(
        None,
        description="interface clamped in these modes, and relative to which mass damping acts; default: "
        "the body's frame",
    )

    def build(self, body: FlexibleBody, frame: Frame) -> RayleighDamping | LinearRayleighDamping:
        """Damping of a body, from the frequencies of the body before reduction."""
        constraint = (NodalFixedFrame(self.held) if self.held else frame).constraint(body)
        known = body.lowest_frequencies(max(self.modes), constraint)
        first, second = (float(known[mode - 1]) for mode in self.modes)
        fitted = replace(rayleigh_from_ratios(self.ratio, first, second), held=self.held)
        return fitted if self.kind == "rayleigh-ratio" else fitted.linearized()


_OF_MASS_AND_STIFFNESS: dict[str, Any] = {
    "alpha": Key(NonNegative, "factor of the mass matrix, one per time"),
    "beta": Key(NonNegative, "factor of the stiffness matrix, a time"),
    "held": Key(description=HELD),
}


class Rayleigh(table_of(RayleighDamping, "rayleigh", **_OF_MASS_AND_STIFFNESS)):
    """Rayleigh damping by mass, and by the material's stiffness K_mat(q) in the deformed body."""


class LinearRayleigh(table_of(LinearRayleighDamping, "linear-rayleigh", **_OF_MASS_AND_STIFFNESS)):
    """Rayleigh damping by mass, and by the stiffness of the undeformed body."""


_MODES = "number of lowest modes that are damped; required for a full body"
_CLAMPED = "interface clamped in these modes, whatever the frame; default: modes in the body's frame"


class Modal(
    table_of(
        ModalDamping,
        "modal",
        ratios=Key(NonNegative, "damping ratio, 0.02 for 2 %", "ratio"),
        n_modes=Key(Annotated[int, Field(ge=1)], _MODES, "modes"),
        held=Key(description=_CLAMPED),
    )
):
    """The same damping ratio on all modes of a reduced body, or on the lowest modes of a body."""


Damping = Annotated[RayleighRatio | Rayleigh | LinearRayleigh | Modal, Field(discriminator="kind")]


def warn_of_ratios(given: Damping | None, body: ReducedBody) -> None:
    """Issue SuppleWarning if modes clamped at an interface have another damping ratio than specified."""
    if isinstance(given, RayleighRatio):
        modes = given.modes
    elif isinstance(given, Modal):
        modes = (1, 2)[: given.modes]
    else:
        return
    if given.held is None or not given.ratio:
        return
    every = clamped_modes(body, given.held).damping_ratios
    found = np.array([every[mode - 1] for mode in modes if mode <= len(every)])
    if np.all(abs(found - given.ratio) <= LARGEST_MISS * given.ratio):
        return
    seen = " and ".join(f"{100 * ratio:.2g}" for ratio in found)
    numbers = " and ".join(map(str, modes))
    warnings.warn(
        f"body '{body.name}': a damping ratio of {100 * given.ratio:.3g} % is given for its modes {numbers} "
        f"with '{given.held}' clamped; the reduced body has {seen} %: its basis lacks motion of these modes. "
        f"Keep more modes, or use a basis with the static shapes of '{given.held}' (craig-bampton, rubin)",
        SuppleWarning,
        stacklevel=2,
    )


def _damped_modes_differ(path: KeyPath, body: Raw) -> Mistakes:
    """The rule that the two modes of a Rayleigh ratio are different numbers from 1."""
    modes = table(body, "damping").get("modes")
    if not isinstance(modes, list) or not all(isinstance(each, int) for each in modes):
        return  # the schema reports it
    if len(modes) == 2 and (modes[0] == modes[1] or min(modes) < 1):
        message = f"give two different mode numbers from 1, for example [1, 2]; got {modes}"
        yield (*path, "damping", "modes"), message


def damps_all_modes(body: Raw) -> bool:
    """True for a body whose damping needs the modes of a reduction of fixed size."""
    given = table(body, "damping")
    return given.get("kind") == "modal" and "modes" not in given


RULES_OF_BODY = (_damped_modes_differ,)
