"""Time steps of a case with explicit parts."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from supple.importers.toml import CheckedTable, Positive
from supple.methods.explicit import (
    ExactLinks,
    Explicit,
    LaggedGyroscopicForce,
    NoGyroscopicForce,
    PredictedLinks,
    ProjectedDifference,
    PublishedScheme,
)


class Projected(CheckedTable):
    """The projected nodal central difference scheme, which conserves momentum exactly."""

    kind: Literal["projected"]

    def build(self) -> ProjectedDifference:
        """The scheme."""
        return ProjectedDifference()


class Published(CheckedTable):
    """The four-point frame scheme as published, for comparison."""

    kind: Literal["published"]
    links: Literal["exact", "predicted"] = Field(
        "exact", description="predicted: as in the published program; rotations lose speed"
    )
    gyroscopic: Literal["lagged", "none"] = Field(
        "lagged", description="lagged: gyroscopic force of the previous half step"
    )

    def build(self) -> PublishedScheme:
        """The scheme."""
        links = ExactLinks() if self.links == "exact" else PredictedLinks()
        force = LaggedGyroscopicForce() if self.gyroscopic == "lagged" else NoGyroscopicForce()
        return PublishedScheme(links, force)


class ExplicitMethod(CheckedTable):
    """Steps of modal parts and of explicit elements."""

    safety: float = Field(0.9, gt=0.0, le=1.0, description="ratio of the step to the stability limit")
    largest_ratio: int = Field(50, ge=1, description="largest number of explicit steps per modal step")
    interface_loss: Positive = Field(
        2e-4,
        description="largest energy lost or gained at the coupling of modal and explicit parts in one output "
        "step, relative to the energy of the run; above it the ratio is halved and the output step repeated",
    )
    scheme: Annotated[Projected | Published, Field(discriminator="kind")] = Projected(kind="projected")

    def build(self) -> Explicit:
        """The method."""
        return Explicit(self.scheme.build(), self.safety, self.largest_ratio, self.interface_loss)
