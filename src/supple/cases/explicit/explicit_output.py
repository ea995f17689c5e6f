"""What is printed and drawn of an explicit run besides its result file."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from supple.importers.toml import CheckedTable


class ExplicitOutput(CheckedTable):
    """What is drawn besides the result file."""

    track: Annotated[tuple[str, ...], Field(strict=False)] = Field(
        (), description="PART.NODE_SET whose mean motion is printed and drawn"
    )
    pictures: bool = Field(True, description="draw the energies and what is tracked (PNG)")
    animation: bool = Field(True, description="draw the motion (GIF), a film for each colour")
    colour: Annotated[tuple[Literal["von-mises", "plastic-strain"], ...], Field(strict=False)] = Field(
        ("von-mises", "plastic-strain"), description="what colours the films"
    )
