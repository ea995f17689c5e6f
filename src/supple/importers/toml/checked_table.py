"""A table of a TOML file that a schema checks, and the types of its values."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

__all__ = ["ZERO", "CheckedTable", "Matrix", "NodeIndices", "NonNegative", "Positive", "Vector"]

# Strict numbers and strings (no "0.02" for 0.02), but a TOML array may fill a tuple.
Vector = Annotated[tuple[float, float, float], Field(strict=False)]
Matrix = Annotated[tuple[Vector, Vector, Vector], Field(strict=False)]
NodeIndices = Annotated[tuple[int, ...], Field(strict=False)]
Positive = Annotated[float, Field(gt=0.0)]
NonNegative = Annotated[float, Field(ge=0.0)]

ZERO: tuple[float, float, float] = (0.0, 0.0, 0.0)


class CheckedTable(BaseModel):
    """A table of a TOML file: unknown keys are mistakes, values cannot change, numbers are finite.

    Its schema may state `json_schema_extra={"renamed": {former key: message}}`.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)
