"""Which quartic tensor a reduced body has: condensed by what its columns leave out, or plain."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from supple.reduction.condensation import Condensation
from supple.reduction.condensed_motion import CondensedMotion
from supple.reduction.tensors import InternalForceTensors


class QuarticChoice(Protocol):
    """CondensedQuartic() or PlainQuartic()."""

    def tensors(self, plain: InternalForceTensors, left_out: Condensation) -> InternalForceTensors:
        """The tensors of the reduced body, from those of its columns alone."""
        ...

    def motion(self, left_out: Condensation) -> CondensedMotion | None:
        """The motion that they let follow the columns."""
        ...


@dataclass(frozen=True)
class CondensedQuartic:
    """Stiff motion outside the columns follows them at rest: its lack blocks nothing; see `Condensation`."""

    def tensors(self, plain: InternalForceTensors, left_out: Condensation) -> InternalForceTensors:
        """The quartic tensor less what that motion releases."""
        return plain.condensed(left_out.energy)

    def motion(self, left_out: Condensation) -> CondensedMotion | None:
        """That motion."""
        return left_out.motion()


@dataclass(frozen=True)
class PlainQuartic:
    """The body moves in its columns alone, as in published work, and locks where they lack stiff motion."""

    def tensors(self, plain: InternalForceTensors, left_out: Condensation) -> InternalForceTensors:  # noqa: ARG002
        """The tensors of the columns."""
        return plain

    def motion(self, left_out: Condensation) -> CondensedMotion | None:  # noqa: ARG002
        """None."""
        return None
