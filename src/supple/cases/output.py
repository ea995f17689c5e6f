"""What is printed and drawn of a run besides its result file."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from supple.cases.body_kinds import kinds_that
from supple.cases.shared_rules import PlaceOf
from supple.importers.toml import CheckedTable, Mistakes, Raw, table, tables


class Output(CheckedTable):
    """What is drawn besides the result file."""

    track: Annotated[tuple[PlaceOf, ...], Field(strict=False)] = Field(
        (), description="BODY.INTERFACE or BODY.NODE_SET whose motion is printed and drawn"
    )
    pictures: bool = Field(True, description="draw mesh, modes, motion and deformed bodies (PNG)")
    animation: bool = Field(True, description="draw the motion (GIF)")
    report: bool = Field(True, description="write the report for a browser (HTML): motion, curves, tables")
    colour: Literal["deflection", "von-mises", "plastic-strain"] = Field(
        "deflection",
        description="what colours animation and report; von-mises also draws contours of the largest stress; "
        "plastic-strain is of bodies in explicit elements",
    )


def _stress_has_elements(raw: Raw) -> Mistakes:
    able = kinds_that("has_elements")
    shown = table(raw, "output").get("colour") == "von-mises"
    if shown and not any(kind in body for _, body in tables(raw, "body") for kind in able):
        message = f"no body has elements whose stress could be shown ({', '.join(able)}); remove the key"
        yield ("output", "colour"), message


def _plastic_strain_has_elements(raw: Raw) -> Mistakes:
    marched = any("explicit" in body for _, body in tables(raw, "body"))
    if table(raw, "output").get("colour") == "plastic-strain" and not marched:
        yield ("output", "colour"), "no body is in explicit elements, which alone yield; remove the key"


RULES = (_stress_has_elements, _plastic_strain_has_elements)
