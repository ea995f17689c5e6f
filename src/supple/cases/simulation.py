"""The time span of a case and its steps; its steady rotation at rest."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Discriminator, Field, Tag

from supple.cases.body_kinds import is_explicit_table
from supple.cases.continuation import StartState
from supple.cases.shared_rules import axes_with_length
from supple.cases.table import Key, Made, OneOf, table_of
from supple.importers.toml import (
    WORD_OR_TABLE,
    ZERO,
    CheckedTable,
    Mistakes,
    Positive,
    Raw,
    Vector,
    names,
    table,
    tables,
)
from supple.integrate import MOST_OUTPUT_TIMES, AdaptiveStep, FixedStep, GeneralizedAlpha, Kinematic, Run
from supple.machine import Spin
from supple.methods.explicit import (
    ExactLinks,
    Explicit,
    LaggedGyroscopicForce,
    NoGyroscopicForce,
    PredictedLinks,
    ProjectedDifference,
    PublishedScheme,
)

_TOLERANCE = "local error allowed per step, relative to the system's size"


class Adaptive(
    table_of(
        AdaptiveStep,
        first=Key(Positive, "first step, a time", default=...),
        largest=Key(Positive, "largest step, a time", default=...),
        tolerance=Key(Positive, _TOLERANCE),
        smallest=None,
    )
):
    """Steps chosen from the local error."""


_LINKS = {"exact": ExactLinks(), "predicted": PredictedLinks()}
_GYROSCOPIC = {"lagged": LaggedGyroscopicForce(), "none": NoGyroscopicForce()}
Projected = table_of(ProjectedDifference, "projected")
Published = table_of(
    PublishedScheme,
    "published",
    links=Key(
        Literal["exact", "predicted"],
        "predicted: as in the published program; rotations lose speed",
        default="exact",
        through=_LINKS.__getitem__,
    ),
    gyroscopic=Key(
        Literal["lagged", "none"],
        "lagged: gyroscopic force of the previous half step",
        default="lagged",
        through=_GYROSCOPIC.__getitem__,
    ),
)


class ExplicitMethod(
    table_of(
        Explicit,
        scheme=Key(Annotated[Made, OneOf(Projected, Published)], default=Projected(kind="projected")),
        safety=Key(Annotated[float, Field(gt=0.0, le=1.0)], "ratio of the step to the stability limit"),
        largest_ratio=Key(Annotated[int, Field(ge=1)], "largest number of explicit steps per modal step"),
        interface_loss=Key(
            Positive,
            "largest energy lost or gained at the coupling of modal and explicit parts in one output step, "
            "relative to the energy of the run; above it the ratio is halved and the output step repeated",
        ),
    )
):
    """Steps of modal parts and of explicit elements."""


class Simulation(CheckedTable):
    """Span of time and method."""

    duration: Positive = Field(description="simulated time, a time")
    output_step: Positive = Field(description="time between stored states, a time")
    step: Positive | None = Field(
        None,
        description="fixed time step, a time; default for explicit parts: the stable step, of a kinematic "
        "run: the output step",
    )
    adaptive: Adaptive | None = None
    rho_inf: float = Field(
        0.8, ge=0.0, le=1.0, description="spectral radius at infinity of generalized-alpha"
    )
    start: Annotated[
        Annotated[Literal["placed", "equilibrium"], Tag(WORD_OR_TABLE[0])]
        | Annotated[StartState, Tag(WORD_OR_TABLE[1])],
        Discriminator(lambda given: WORD_OR_TABLE[not isinstance(given, str)]),
    ] = Field("placed", description="as the bodies are placed, from the equilibrium, or from a state")

    assemble: bool = Field(False, description="close open joints by rigid motions of the bodies")
    explicit: ExplicitMethod | None = None
    kinematic: bool = Field(False, description="kinematic analysis of a machine without degrees of freedom")

    def build(self) -> Run:
        """The run."""
        fixed = FixedStep(self.step) if self.step else None
        step = self.adaptive.build() if self.adaptive else fixed
        begin = self.start.time if isinstance(self.start, StartState) else 0.0
        if self.explicit is not None:
            return Run(self.duration, self.output_step, step, self.explicit.build(), start=begin)
        method = Kinematic() if self.kinematic else GeneralizedAlpha(self.rho_inf)
        return Run(self.duration, self.output_step, step=step, method=method, start=begin)


_NAMES = Annotated[tuple[str, ...], Field(strict=False)]


class SpinTable(
    table_of(
        Spin,
        rate=Key(float, "angular velocity, rad per time"),
        axis=Key(Vector, "direction of the axis, global axes, not zero", default=...),
        point=Key(Vector, "point on the axis, global axes, a length", default=ZERO),
        bodies=Key(_NAMES, "names of the rotating bodies; default: all"),
    )
):
    """The steady rotation in `supple static`, in `supple modes`, and of runs that start in equilibrium."""


def _steps_are_given_once(raw: Raw) -> Mistakes:
    given = raw.get("simulation")
    if isinstance(given, dict) and ("step" in given) == ("adaptive" in given):
        if "step" not in given and (_marches_explicitly(raw) or given.get("kinematic") is True):
            return  # the step is the stable one; positions without integration need none
        path = ("simulation", "step") if "step" in given else ("simulation",)
        yield path, "give either step = TIME or adaptive = {first = .., largest = ..}, not both or none"


def _marches_explicitly(raw: Raw) -> bool:
    return any(is_explicit_table(body) for _, body in tables(raw, "body"))


def _an_explicit_march_has_its_own_steps(raw: Raw) -> Mistakes:
    given = table(raw, "simulation")
    if not _marches_explicitly(raw):
        if "explicit" in given:
            yield ("simulation", "explicit"), "no body is modal or explicit; remove the key"
        return
    for key in ("adaptive", "rho_inf", "kinematic"):
        if key in given:
            yield ("simulation", key), "not available in explicit runs; remove the key"
    for key, asked in table(raw, "error").items():
        if asked:
            yield ("error", key), "the error of an explicit run is not estimated; remove the key"
    if not any("explicit" in body for _, body in tables(raw, "body")):
        return
    what = "explicit elements start as they are placed; remove the key"
    if given.get("start") == "equilibrium":
        yield ("simulation", "start"), what
    if "assemble" in given:
        yield ("simulation", "assemble"), what


def _first_step_is_not_too_long(raw: Raw) -> Mistakes:
    given = table(table(raw, "simulation"), "adaptive")
    first, largest = given.get("first"), given.get("largest")
    if isinstance(first, int | float) and isinstance(largest, int | float) and first > largest:
        path = ("simulation", "adaptive", "first")
        yield path, f"the first step, {first}, exceeds the largest, {largest}; give a smaller one"


def output_steps_fill_the_duration(raw: Raw) -> Mistakes:
    """The rule that the duration is a number of output steps, few enough to be stored."""
    given = table(raw, "simulation")
    output_step, duration = given.get("output_step"), given.get("duration")
    if not (isinstance(output_step, int | float) and isinstance(duration, int | float)) or output_step <= 0:
        return
    path = ("simulation", "output_step")
    intervals = duration / output_step
    if not intervals <= MOST_OUTPUT_TIMES:  # also for a duration that is not a number
        yield (
            path,
            f"a duration of {duration} in steps of {output_step} gives more than the {MOST_OUTPUT_TIMES} "
            "output times that are stored; give a longer output_step (step may stay)",
        )
    elif intervals < 1:
        yield path, f"{output_step} is longer than the duration, {duration}; give a shorter one"
    elif abs(intervals - round(intervals)) > 1e-6:
        better = duration / round(intervals)
        yield path, f"the duration, {duration}, is not a multiple of {output_step}; try {better:.6g}"


def _a_kinematic_run_takes_no_steps_of_an_integrator(raw: Raw) -> Mistakes:
    given = table(raw, "simulation")
    if given.get("kinematic") is not True:
        return
    for key in ("adaptive", "rho_inf"):
        if key in given:
            yield ("simulation", key), "not used in a kinematic run: remove it"
    if given.get("start", "placed") != "placed":
        yield ("simulation", "start"), "the joints define the start of a kinematic run: remove it"


def _a_state_is_assembled(raw: Raw) -> Mistakes:
    given = table(raw, "simulation")
    if isinstance(given.get("start"), dict) and given.get("assemble") is True:
        yield ("simulation", "assemble"), "the start defines the positions of the bodies; remove the key"


def _spinning_bodies_exist(raw: Raw) -> Mistakes:
    named = table(raw, "spin").get("bodies")
    known = names(raw, "body")
    for name in named if isinstance(named, list) else ():
        if name not in known:
            yield ("spin", "bodies"), f"there is no body '{name}'; there are: {', '.join(known)}"


RULES = (
    lambda raw: axes_with_length(("spin",), table(raw, "spin")),
    _spinning_bodies_exist,
    _a_kinematic_run_takes_no_steps_of_an_integrator,
    _a_state_is_assembled,
    _steps_are_given_once,
    _an_explicit_march_has_its_own_steps,
    _first_step_is_not_too_long,
    output_steps_fill_the_duration,
)
