"""A slender elastic body in intrinsic modes, for rotations of any size, without a floating frame."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Annotated, Literal

from pydantic import Field

from supple.body import Damping, FlexibleBody
from supple.cases.shared_rules import BODY_AXIS
from supple.importers.toml import (
    CheckedTable,
    KeyPath,
    Mistakes,
    NodeIndices,
    Raw,
    Vector,
    names,
    table,
    tables,
    unknown,
)
from supple.integrate import Run, Solution, Validity
from supple.machine import System
from supple.methods.intrinsic import (
    BALL,
    CLAMPED,
    FREE,
    CondensedLine,
    IntrinsicBody,
    LoadPath,
    RootSupport,
    condense,
    enough_modes,
    hinged,
    intrinsic_body,
    released,
    sliding,
)
from supple.simulation import simulate

Support = Literal["clamped", "free", "ball", "hinged", "sliding"]
_WITH_AXIS = {"hinged": hinged, "sliding": sliding}
_WITHOUT_AXIS = {"clamped": CLAMPED, "free": FREE, "ball": BALL}
_HELD_BY = {
    "clamped": ("fixed", "prescribed-rotation", "prescribed-translation"),
    "ball": ("ball",),
    "hinged": ("revolute",),
    "sliding": ("prismatic",),
}
Row = Annotated[tuple[float, float, float, float, float, float], Field(strict=False)]
RootMass = Annotated[tuple[Row, Row, Row, Row, Row, Row], Field(strict=False)]
_INSTEAD_OF = ("frame", "reduction", "split", "linear")


class ModeAccuracy(CheckedTable):
    """The allowed error of the truncated modes."""

    relative: float = Field(
        1e-3, gt=0, lt=1, description="largest RMS error of positions of stations, relative to the deflection"
    )


class Condense(CheckedTable):
    """Stations along a load path, and the modes on them."""

    model_config = BODY_AXIS

    root: str = Field(description="interface at the start of the load path; may be supported by a joint")
    tip: str | None = Field(None, description="interface at the end of the path, for bodies with elements")
    stations: int | None = Field(
        None,
        ge=2,
        description="number of stations along the path, both ends included, for bodies with elements",
    )
    paths: Annotated[tuple[NodeIndices, ...], Field(strict=False)] | None = Field(
        None,
        description="for a matrices body, condensed by another program: its grids from the root outwards, "
        "one list per branch, beginning at the branching grid",
    )
    root_mass: RootMass | None = Field(
        None, description="mass matrix (6, 6) of the first grid, if the matrices omit it; default: none"
    )
    modes: int | None = Field(
        None,
        ge=1,
        description="number of lowest elastic modes; second-order modes of large bending are added; "
        "default: all",
    )
    accuracy: ModeAccuracy | None = Field(
        None, description="instead of modes: accuracy that determines their number"
    )
    support: Support = Field(
        "clamped",
        description="boundary condition of the root; clamped also for a prescribed motion",
    )
    body_axis: Vector | None = Field(None, description="direction of a hinged or sliding root, in body axes")
    released: bool = Field(
        False,
        description="true if joints connect the body to other bodies, or act at its tip: rigid-body motion "
        "is added to the modes on its support",
    )

    def build(self, body: FlexibleBody, damping: Damping | None) -> IntrinsicBody:
        """The body in its intrinsic modes, on stations along its elements."""
        assert self.tip is not None  # rules of the case file
        assert self.stations is not None
        path = LoadPath(self.root, self.tip, self.stations)
        return self._held(condense(body, path, support=self._support(), n_modes=self.modes, damping=damping))

    def on_line(
        self, line: CondensedLine, stations: Mapping[str, int], damping: Damping | None
    ) -> IntrinsicBody:
        """The body in its intrinsic modes, on the stations of a condensation by another program."""
        support = self._support()
        return self._held(intrinsic_body(line, support, self.modes, stations=stations, damping=damping))

    def _held(self, made: IntrinsicBody) -> IntrinsicBody:
        return released(made) if self.released else made

    def _support(self) -> RootSupport:
        if self.body_axis is not None:  # a rule of the case file
            return _WITH_AXIS[self.support](self.body_axis)
        return _WITHOUT_AXIS[self.support]


def with_sufficient_modes(
    system: System, run: Run, tables: Mapping[str, Condense], notify: Callable[[str, float], None]
) -> System:
    """The machine with the number of modes that the accuracy of its condensed bodies needs, from trial runs.

    tables : by body name; the smallest of their accuracies applies to all these bodies
    Raises ModelError as `enough_modes`.
    """
    asked = {name: own.accuracy.relative for name, own in tables.items() if own.accuracy is not None}
    if not asked:
        return system

    def simulated(machine: System) -> Solution:
        numbers = ", ".join(str(p.body.n_coordinates) for p in machine.bodies if p.body.name in asked)
        words = f"finding the number of modes: {numbers}"
        notify(words, 0.0)
        return simulate(machine, replace(run, validity=Validity()), progress=lambda done: notify(words, done))

    return enough_modes(system, simulated, tolerance=min(asked.values()), bodies=asked).system


def is_condensed(body: Raw) -> bool:
    """True for a body in intrinsic modes, which has no floating frame."""
    return "condense" in body


def _has_no_floating_frame(path: KeyPath, body: Raw) -> Mistakes:
    if not is_condensed(body):
        return
    for needless in (each for each in _INSTEAD_OF if each in body):
        yield (*path, needless), f"a condensed body has its own modes and takes no {needless}; remove the key"
    damping = table(body, "damping").get("kind")
    if "held" in table(body, "damping"):
        yield (
            (*path, "damping", "held"),
            "the damping of a condensed body acts on its modes, not relative to an interface; remove held",
        )
    if damping not in (None, "rayleigh", "modal"):
        message = f'a condensed body takes damping of kind "rayleigh" or "modal", not "{damping}"'
        yield (*path, "damping", "kind"), message


def _modes_are_counted_once(path: KeyPath, body: Raw) -> Mistakes:
    given = table(body, "condense")
    if "accuracy" in given and "modes" in given:
        yield (*path, "condense", "accuracy"), "give either modes or accuracy, not both"


def _path_is_between_interfaces(path: KeyPath, body: Raw) -> Mistakes:
    given, known = table(body, "condense"), names(body, "interface")
    for end in ("root", "tip"):
        if isinstance(given.get(end), str) and given[end] not in known:
            yield (*path, "condense", end), unknown("interface", given[end], known)


def _axis_suits_the_support(path: KeyPath, body: Raw) -> Mistakes:
    given = table(body, "condense")
    needs = str(given.get("support")) in _WITH_AXIS
    if needs and "body_axis" not in given:
        yield (
            (*path, "condense"),
            f"a {given['support']} root needs body_axis = [x, y, z], along the axes of the body",
        )
    if not needs and "body_axis" in given:
        yield (
            (*path, "condense", "body_axis"),
            "only a hinged or sliding root has a body_axis; remove the key",
        )


def _joints_suit_the_supports(raw: Raw) -> Mistakes:
    for path, body in tables(raw, "body"):
        given, name = table(body, "condense"), str(body.get("name"))
        root = f"{name}.{given.get('root')}"
        if not is_condensed(body) or given.get("released") is True:
            continue
        # A free root needs no joint; the schema reports an unknown support.
        if str(given.get("support", "clamped")) not in _HELD_BY:
            continue
        joints = [
            (at, own)
            for at, own in tables(raw, "joint")
            if name in [end.partition(".")[0] for end in _ends(own)]
        ]
        remedy = (
            f'set released = true in its condense; support = "{given.get("support", "clamped")}" may stay'
        )
        if len(joints) > 1:
            yield (*path, "condense"), f"{len(joints)} joints support {name!r}: {remedy}"
            continue
        if not joints:
            yield (
                (*path, "condense"),
                f'no joint supports {name!r}: set support = "free", or join {root!r} to ground',
            )
        for at, joint in joints:
            own = _ends(joint)
            if set(own) != {"ground", root}:
                other = next((end for end in own if end not in ("ground", root)), root)
                yield at, f"its ends must be ground and the root of {name!r}; one end is {other!r}: {remedy}"
            elif joint.get("kind") not in _HELD_BY[given.get("support", "clamped")]:
                fitting = [key for key, kinds in _HELD_BY.items() if joint.get("kind") in kinds]
                better = f'set support = "{fitting[0]}", or ' if fitting else ""
                yield (
                    (*at, "kind"),
                    f"a {joint.get('kind')} joint does not fit a {given.get('support', 'clamped')} root: "
                    f"{better}{remedy}",
                )


def _ends(joint: Raw) -> list[str]:
    return [end for end in (joint.get("first"), joint.get("second")) if isinstance(end, str)]


def _marches_in_fixed_steps(raw: Raw) -> Mistakes:
    """The rule that intrinsic bodies need fixed steps, without assembly and kinematic analysis."""
    condensed = next((body.get("name") for _, body in tables(raw, "body") if is_condensed(body)), None)
    if condensed is None:
        return
    given = table(raw, "simulation")
    for key, refused, remedy in (
        ("adaptive", "adaptive" in given, "give step = TIME"),
        ("assemble", given.get("assemble") is True, "place the bodies so that all joints fit"),
        ("kinematic", given.get("kinematic") is True, "make it a rigid body, or remove the key"),
    ):
        if refused:
            yield ("simulation", key), f"not available with the condensed body {condensed!r}: {remedy}"


RULES_OF_BODY = (
    _has_no_floating_frame,
    _modes_are_counted_once,
    _path_is_between_interfaces,
    _axis_suits_the_support,
)
RULES = (_joints_suit_the_supports, _marches_in_fixed_steps)
