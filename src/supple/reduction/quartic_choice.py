"""The choice of the quartic tensor of a reduced body: condensed or plain."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from supple.reduction.condensation import Condensation
from supple.reduction.condensed_motion import CondensedMotion
from supple.reduction.tensors import StrainProducts

__all__ = ["CondensedQuartic", "PlainQuartic", "QuarticChoice"]


class QuarticChoice(Protocol):
    """CondensedQuartic() or PlainQuartic()."""

    def strains(self, plain: StrainProducts, left_out: Condensation) -> StrainProducts:
        """Strain products of the reduced body, from those of its columns alone."""
        ...

    def motion(self, left_out: Condensation) -> CondensedMotion | None:
        """The condensed motion z; None if no motion is condensed."""
        ...


@dataclass(frozen=True)
class CondensedQuartic:
    """Motion outside the columns follows the columns statically; see `Condensation`.

    The body does not lock if its basis contains the static shapes of the interfaces.
    """

    def strains(self, plain: StrainProducts, left_out: Condensation) -> StrainProducts:
        """Strain products of the columns, less those that the condensed motion releases."""
        return plain.condensed(left_out.energy)

    def motion(self, left_out: Condensation) -> CondensedMotion | None:
        """The condensed motion."""
        return left_out.motion()


@dataclass(frozen=True)
class PlainQuartic:
    """The body moves in its columns alone, as in published work; it locks where they lack stiff motion."""

    def strains(self, plain: StrainProducts, left_out: Condensation) -> StrainProducts:  # noqa: ARG002
        """The strain products of the columns, unchanged."""
        return plain

    def motion(self, left_out: Condensation) -> CondensedMotion | None:  # noqa: ARG002
        """None."""
        return None
