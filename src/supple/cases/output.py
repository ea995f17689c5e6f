"""Output of a run besides its result file: tables, pictures, report."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from supple.cases.body_kinds import kinds_that
from supple.cases.shared_rules import PlaceOf, joint_names
from supple.cases.table import Key, part, table_of
from supple.errors import ModelError
from supple.importers.toml import CheckedTable, Mistakes, Positive, Raw, Vector, table, tables
from supple.results.camera import Camera, View
from supple.results.film import Film, RotorAngle


class FilmTable(
    table_of(
        Film,
        at=part(
            RotorAngle,
            joint=Key(
                str | None,
                "name of a joint: frames are drawn when its rotation equals angle, so a rotor appears fixed",
                default=None,
            ),
            angle=Key(float, "angle about the z axis of the joint, rad; zero at assembly"),
        ),
    )
):
    """Output times, speed and format of an animation."""

    format: Literal["gif", "mp4"] = Field("gif", description="mp4 needs pip install 'supple[film]'")


class CameraTable(CheckedTable):
    """The viewing direction of pictures and animation."""

    along: Vector = Field(description="direction of view, global")
    up: Vector = Field(description="upward direction in the picture, global")

    def build(self) -> Camera:
        """The camera."""
        return Camera.looking(along=self.along, up=self.up)


class Output(CheckedTable):
    """Pictures, animation and report, which are written besides the result file."""

    track: Annotated[tuple[PlaceOf, ...], Field(strict=False)] = Field(
        (), description="BODY.INTERFACE or BODY.NODE_SET whose motion is printed and drawn"
    )
    pictures: bool = Field(True, description="draw mesh, modes, motion and deformed bodies (PNG)")
    animation: bool = Field(True, description="draw the motion (GIF or MP4)")
    film: FilmTable = Field(
        default_factory=FilmTable,
        description="output times, speed and format of the animation",
    )
    camera: CameraTable | None = Field(
        None, description="viewing direction of pictures and animation; default: chosen for the machine"
    )
    enlargement: Positive | None = Field(
        None,
        description="factor on deflections; default: 1 in the animation; in pictures of single bodies, a "
        "factor that makes small deflections visible",
    )
    report: bool = Field(True, description="write the report for a browser (HTML): motion, curves, tables")
    colour: Literal["deflection", "von-mises", "plastic-strain"] = Field(
        "deflection",
        description="colours of animation and report; von-mises adds contours of the largest stress; "
        "plastic-strain is for bodies in explicit elements",
    )

    @property
    def view(self) -> View:
        """Camera and enlargement of pictures."""
        return View(None if self.camera is None else self.camera.build(), self.enlargement)


def _the_film_can_be_made(raw: Raw) -> Mistakes:
    given = table(table(raw, "output"), "film")
    joint, joints = given.get("joint"), joint_names(raw)
    if isinstance(joint, str) and joint not in joints:
        there = ", ".join(joints) or "none"
        yield ("output", "film", "joint"), f"there is no joint '{joint}'; there are: {there}"
    if "angle" in given and joint is None:
        yield ("output", "film", "angle"), "angle needs a joint; add joint, or remove the key"
    numbers = {
        key: each
        for key, each in given.items()
        if key in ("frames_per_second", "speed", "start", "end") and type(each) in (int, float)
    }
    at = RotorAngle(joint) if isinstance(joint, str) else None
    if all(numbers.get(key, 1.0) > 0 for key in ("frames_per_second", "speed")):
        try:
            Film(**numbers, at=at)
        except ModelError as error:
            yield ("output", "film"), str(error)


def _the_camera_looks_somewhere(raw: Raw) -> Mistakes:
    given = table(table(raw, "output"), "camera")
    try:
        CameraTable.model_validate(given).build()
    except ModelError as error:
        yield ("output", "camera"), str(error)
    except ValueError:
        return  # the schema reports it


def _bodies_have_what_is_shown(raw: Raw) -> Mistakes:
    given, able = table(raw, "output"), kinds_that("has_elements")
    bodies = [body for _, body in tables(raw, "body")]
    marched = any("explicit" in body for body in bodies)
    if given.get("colour") == "von-mises" and not any(kind in body for body in bodies for kind in able):
        message = f"no body has elements whose stress could be shown ({', '.join(able)}); remove the key"
        yield ("output", "colour"), message
    if given.get("colour") == "plastic-strain" and not marched:
        yield ("output", "colour"), "without explicit elements there is no plastic strain; remove the key"
    if marched and given.get("enlargement", 1) != 1:
        message = "explicit elements have no separate rigid motion and deformation; remove the key"
        yield ("output", "enlargement"), message


RULES = (_bodies_have_what_is_shown, _the_film_can_be_made, _the_camera_looks_somewhere)
