"""The span of time of an explicit case, and what its steps are made of."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from supple.cases.simulation import output_steps_fill_the_duration
from supple.explicit import (
    ExactLinks,
    ExplicitOptions,
    LaggedGyroscopicForce,
    NoGyroscopicForce,
    PredictedLinks,
    ProjectedDifference,
    PublishedScheme,
)
from supple.importers.toml import CheckedTable, Positive
from supple.integrate import Run


class Projected(CheckedTable):
    """The projected nodal central difference: momentum exact."""

    kind: Literal["projected"]

    def build(self) -> ProjectedDifference:
        """The scheme."""
        return ProjectedDifference()


class Published(CheckedTable):
    """The four-point frame as published, to reproduce it."""

    kind: Literal["published"]
    links: Literal["exact", "predicted"] = Field(
        "exact", description="predicted: of the open implementation, which brake a rotation"
    )
    gyroscopic: Literal["lagged", "none"] = Field(
        "lagged", description="gyroscopic force of the half step before"
    )

    def build(self) -> PublishedScheme:
        """The scheme."""
        links = ExactLinks() if self.links == "exact" else PredictedLinks()
        force = LaggedGyroscopicForce() if self.gyroscopic == "lagged" else NoGyroscopicForce()
        return PublishedScheme(links, force)


class ExplicitSimulation(CheckedTable):
    """Span of time and steps."""

    duration: Positive = Field(description="a time")
    output_step: Positive = Field(description="time between stored states")
    step: Positive | None = Field(
        None, description="of the explicit nodes; what is stable, chosen at every output time, if left out"
    )
    safety: float = Field(0.9, gt=0.0, le=1.0, description="part of the step limit that is used")
    largest_ratio: int = Field(50, ge=1, description="explicit steps in one step of the modal parts, at most")
    interface_loss: Positive = Field(
        2e-4,
        description="of the energy, lost or won between modal and explicit parts from one output time to the "
        "next: above it the ratio is halved, and the way repeated",
    )
    scheme: Annotated[Projected | Published, Field(discriminator="kind")] = Projected(kind="projected")

    def build(self) -> Run:
        """The run."""
        return Run(self.duration, self.output_step)

    def options(self) -> ExplicitOptions:
        """How it steps."""
        return ExplicitOptions(
            scheme=self.scheme.build(),
            safety=self.safety,
            step=self.step,
            largest_ratio=self.largest_ratio,
            interface_loss=self.interface_loss,
        )


RULES = (output_steps_fill_the_duration,)
