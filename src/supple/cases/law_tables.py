"""The tables of laws of time: how a load or a prescribed motion goes with time."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from supple.cases.table import Positive, Table


class Constant(Table):
    """value"""

    kind: Literal["constant"]
    value: float


class Ramp(Table):
    """From 0 to value in duration with a smooth start and end, then constant."""

    kind: Literal["ramp"]
    value: float
    duration: Positive = Field(description="s")


class Sine(Table):
    """amplitude sin(2 pi frequency_hz t)"""

    kind: Literal["sine"]
    amplitude: float
    frequency_hz: Positive = Field(description="Hz")


class SpinUp(Table):
    """An angle (or path) whose rate grows smoothly from 0 to speed in duration, then stays."""

    kind: Literal["spin-up"]
    speed: float = Field(description="rate after the spin-up, rad/s or m/s")
    duration: Positive = Field(description="s")


class TableLaw(Table):
    """Values from a file, joined by a curve that is smooth enough for prescribed motion (cubic spline)."""

    kind: Literal["table"]
    file: str = Field(description="CSV file of time,value rows beside the case file")


Law = Annotated[Constant | Ramp | Sine | SpinUp | TableLaw, Field(discriminator="kind")]
