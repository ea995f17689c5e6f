"""A slender elastic body in its intrinsic modes: any rotation, instead of a reduction in a floating frame."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from supple.body import Damping, FlexibleBody
from supple.importers.toml import CheckedTable, KeyPath, Mistakes, Raw, Vector, names, table, unknown
from supple.intrinsic import (
    BALL,
    CLAMPED,
    FREE,
    IntrinsicBody,
    LoadPath,
    RootSupport,
    condense,
    hinged,
    sliding,
)

Support = Literal["clamped", "free", "ball", "hinged", "sliding"]
_WITH_AXIS = {"hinged": hinged, "sliding": sliding}
_WITHOUT_AXIS = {"clamped": CLAMPED, "free": FREE, "ball": BALL}
_INSTEAD_OF = ("frame", "reduction", "split", "linear")


class Condense(CheckedTable):
    """Stations along a load path, and the modes on them."""

    root: str = Field(description="interface where the load path begins, and where a joint may hold the body")
    tip: str = Field(description="interface where it ends")
    stations: int = Field(ge=2, description="stations along the path, both ends included")
    modes: int | None = Field(None, ge=1, description="elastic modes; all if left out")
    support: Support = Field(
        "clamped",
        description="what the joint at the root leaves free; clamped also where it prescribes a motion",
    )
    axis: Vector | None = Field(None, description="of a hinged or sliding root, in the mesh axes")

    def build(self, body: FlexibleBody, damping: Damping | None) -> IntrinsicBody:
        """The body in its intrinsic modes."""
        path = LoadPath(self.root, self.tip, self.stations)
        return condense(body, path, support=self._support(), n_modes=self.modes, damping=damping)

    def _support(self) -> RootSupport:
        if self.axis is not None:  # a rule of the case file
            return _WITH_AXIS[self.support](self.axis)
        return _WITHOUT_AXIS[self.support]


def is_condensed(body: Raw) -> bool:
    """True of a body in its intrinsic modes, which has no floating frame."""
    return "condense" in body


def _has_no_floating_frame(path: KeyPath, body: Raw) -> Mistakes:
    if not is_condensed(body):
        return
    for needless in (each for each in _INSTEAD_OF if each in body):
        yield (*path, needless), f"a condensed body has its own modes and takes no {needless}; remove the key"
    damping = table(body, "damping").get("kind")
    if damping not in (None, "rayleigh", "modal"):
        message = f'a condensed body takes damping of kind "rayleigh" or "modal", not "{damping}"'
        yield (*path, "damping", "kind"), message


def _path_is_between_interfaces(path: KeyPath, body: Raw) -> Mistakes:
    given, known = table(body, "condense"), names(body, "interface")
    for end in ("root", "tip"):
        if isinstance(given.get(end), str) and given[end] not in known:
            yield (*path, "condense", end), unknown("interface", given[end], known)


def _axis_suits_the_support(path: KeyPath, body: Raw) -> Mistakes:
    given = table(body, "condense")
    needs = given.get("support") in _WITH_AXIS
    if needs and "axis" not in given:
        yield (*path, "condense"), f"a {given['support']} root needs axis = [x, y, z] in the mesh axes"
    if not needs and "axis" in given:
        yield (*path, "condense", "axis"), "only a hinged or sliding root has an axis; remove the key"


RULES_OF_BODY = (_has_no_floating_frame, _path_is_between_interfaces, _axis_suits_the_support)
