"""The damping of an elastic body."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from supple.body import (
    FlexibleBody,
    Frame,
    LinearRayleighDamping,
    ModalDamping,
    NodalFixedFrame,
    RayleighDamping,
    rayleigh_at_modes,
)
from supple.cases.table import Made
from supple.importers.toml import CheckedTable, KeyPath, Mistakes, NonNegative, Raw, table


class _RatioOfTwoModes(CheckedTable):
    """The same damping ratio on two modes of the body in its frame."""

    ratio: NonNegative = Field(description="damping ratio, 0.02 for 2 %")
    modes: Annotated[tuple[int, int], Field(strict=False)] = Field((1, 2), description="mode numbers from 1")
    held: str | None = Field(
        None, description="interface held while these modes vibrate; none: free in the frame"
    )

    def _fitted(self, body: FlexibleBody, frame: Frame) -> RayleighDamping:
        constraint = (NodalFixedFrame(self.held) if self.held else frame).constraint(body)
        return rayleigh_at_modes(body.stiffness, body.mass, constraint, self.ratio, self.modes)


class RayleighRatio(_RatioOfTwoModes):
    """Rayleigh damping by strain rate with the same ratio on two modes of the body in its frame."""

    kind: Literal["rayleigh-ratio"]

    def build(self, body: FlexibleBody, frame: Frame) -> RayleighDamping:
        """Damping of a body; the frequencies are those of the whole mesh."""
        return self._fitted(body, frame)


class LinearRayleighRatio(_RatioOfTwoModes):
    """The same with the stiffness of the undeformed body, as the literature has it."""

    kind: Literal["linear-rayleigh-ratio"]

    def build(self, body: FlexibleBody, frame: Frame) -> LinearRayleighDamping:
        """Damping of a body; the frequencies are those of the whole mesh."""
        return self._fitted(body, frame).linearized()


class Rayleigh(Made):
    """Damping alpha M + beta K_mat(q) that follows the strain rate."""

    makes = RayleighDamping

    kind: Literal["rayleigh"]
    alpha: NonNegative = Field(description="per time")
    beta: NonNegative = Field(description="a time")


class LinearRayleigh(Made):
    """Rayleigh damping alpha M + beta K with the stiffness of the undeformed body."""

    makes = LinearRayleighDamping

    kind: Literal["linear-rayleigh"]
    alpha: NonNegative = Field(description="per time")
    beta: NonNegative = Field(description="a time")


class Modal(Made):
    """The same damping ratio on the modes of the body in its frame: all of a reduced body, or the lowest."""

    makes = ModalDamping

    kind: Literal["modal"]
    ratio: NonNegative = Field(description="damping ratio, 0.02 for 2 %")
    modes: int | None = Field(
        None,
        ge=1,
        description="number of modes damped, from the lowest up; a body that is not reduced needs it",
    )


Damping = Annotated[
    RayleighRatio | Rayleigh | LinearRayleighRatio | LinearRayleigh | Modal, Field(discriminator="kind")
]


def _damped_modes_differ(path: KeyPath, body: Raw) -> Mistakes:
    """The rule on the two modes of a Rayleigh ratio."""
    modes = table(body, "damping").get("modes")
    if isinstance(modes, list) and len(modes) == 2 and (modes[0] == modes[1] or min(modes) < 1):
        message = f"give two different mode numbers from 1, for example [1, 2]; got {modes}"
        yield (*path, "damping", "modes"), message


def damps_all_modes(body: Raw) -> bool:
    """True of a body whose damping needs the modes of a reduction of fixed size."""
    given = table(body, "damping")
    return given.get("kind") == "modal" and "modes" not in given


RULES_OF_BODY = (_damped_modes_differ,)
