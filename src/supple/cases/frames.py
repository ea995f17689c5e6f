"""The floating frame of an elastic body."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from supple.body import MeanAxisFrame, NodalFixedFrame
from supple.cases.table import Table


class MeanAxis(Table):
    """Frame that follows the mean motion of the body."""

    kind: Literal["mean-axis"]

    def build(self) -> MeanAxisFrame:
        """The frame."""
        return MeanAxisFrame()


class NodalFixed(Table):
    """Frame fixed to one interface."""

    kind: Literal["nodal-fixed"]
    interface: str = Field(description="name of the interface the frame moves with")

    def build(self) -> NodalFixedFrame:
        """The frame."""
        return NodalFixedFrame(self.interface)


Frame = Annotated[MeanAxis | NodalFixed, Field(discriminator="kind")]
