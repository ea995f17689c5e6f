"""The reduction of a body: a basis of fixed size, or the start of a self-correction."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Annotated, Any, Literal

from pydantic import Field

from supple import reduction
from supple.body import FlexibleBody
from supple.cases.body_kinds import is_elastic, kind_of
from supple.cases.damping import damps_all_modes
from supple.cases.stated_error import OfInterest
from supple.cases.table import Key, Made, OneOf, table_of
from supple.error import ReductionStart, SelfCorrection
from supple.importers.toml import CheckedTable, KeyPath, Mistakes, Positive, Raw, names, table
from supple.quantities import QuantityOfInterest
from supple.reduction import DerivativeChoice, LinearBasisRecipe, QuarticChoice
from supple.reduction.eigenvalues.mode_search import search_words

DEFAULT_ACCURACY = 1e-3
"""Default target error: largest RMS error of the nodes, relative to their largest displacement."""
FIRST_MODES = 5
FIRST_DERIVATIVES = 5
CANDIDATES_PER_MODE = 5
"""Default number of candidate modes per selected mode."""

Report = Callable[[str], None]
"""Called with descriptions of the progress of a search for the number of modes."""


_COUNT = Annotated[int, Field(ge=1)]
AllPairsCompressed = table_of(
    reduction.CompressedDerivatives, "compressed", n=Key(_COUNT, "directions kept", "number"), weights=None
)
Picked = table_of(
    reduction.PickedDerivatives, "picked", n=Key(_COUNT, "derivatives kept", "number"), criterion=None
)
NoDerivatives = table_of(reduction.NoDerivatives, "none")
Derivatives = Annotated[Made, OneOf(AllPairsCompressed, Picked, NoDerivatives)]


_CONDENSED = Field(
    None,
    description="true: missing stiff motion is condensed statically; false: plain tensors, as published, "
    "which lock without this motion; default: true for a fixed size, false during self-correction",
)


def quartic_choice(condensed: bool | None, default: QuarticChoice) -> QuarticChoice:
    """The choice of quartic tensors: condensed if true, plain if false, `default` if None."""
    if condensed is None:
        return default
    return reduction.CondensedQuartic() if condensed else reduction.PlainQuartic()


def derivative_choice(table: Made | None) -> DerivativeChoice:
    """The choice of modal derivatives from its table; no derivatives without a table."""
    return table.build() if table else reduction.NoDerivatives()


class Accuracy(CheckedTable):
    """The target error of a self-correcting reduction; default: 1e-3 relative."""

    relative: Positive | None = Field(
        None,
        description="largest RMS error of the nodes, relative to their largest displacement from the first "
        "interface",
    )
    absolute: Positive | None = Field(None, description="largest RMS error of the nodes, a length")
    instants: int = Field(
        24,
        ge=1,
        description="number of times at which the residual is evaluated, besides load peaks and kinks",
    )
    directions: int = Field(4, ge=1, description="number of columns added per round")
    largest_size: int = Field(60, ge=1, description="largest number of coordinates")
    max_rounds: int = Field(
        8, ge=1, description="largest number of enrichments, one in each round after the first"
    )
    of: OfInterest | None = Field(
        None, description="quantity whose error is limited; default: the positions of all nodes"
    )

    def target(self, quantity: QuantityOfInterest | None = None) -> SelfCorrection:
        """Target error and settings of the self-correction; `quantity` is built from the table `of`."""
        given: dict[str, Any] = self.model_dump(exclude={"of"}) | {"of": quantity}
        if self.relative is None and self.absolute is None:
            given["relative"] = DEFAULT_ACCURACY
        return SelfCorrection(**given)


class Basis(Made):
    """The reduction of a body."""

    choice = "basis"

    @property
    def corrects_itself(self) -> bool:
        """False; bases that can correct themselves override it."""
        return False


class FullOrder(Basis):
    """No reduction: every freedom of the mesh is simulated."""

    basis: Literal["none"]


class Correctable(Basis):
    """A basis that corrects itself if given an accuracy; otherwise its size is fixed."""

    derivatives: Derivatives | None = None
    accuracy: Accuracy | None = None
    condensed: bool | None = _CONDENSED

    def recipe(self, _report: Report | None = None) -> LinearBasisRecipe:
        """The linear columns; with an accuracy, those that the self-correction starts with."""
        return self.build()

    @property
    def corrects_itself(self) -> bool:
        """True for a basis with an accuracy."""
        return self.accuracy is not None


class Sized(Correctable):
    """A number of modes and static columns; corrects itself if an accuracy, or no number, is given."""

    modes: int | None = None
    steady: bool = Field(
        True,
        description="for a fixed size; false omits the static responses to steady motion, up to twelve "
        "columns besides the modes",
    )

    @property
    def corrects_itself(self) -> bool:
        """True with an accuracy, or without a number of modes."""
        return self.accuracy is not None or self.modes is None

    def recipe(self, _report: Report | None = None) -> LinearBasisRecipe:
        """The linear columns; of a basis that corrects itself, those that it starts with."""
        columns = self.build()
        return columns if self.corrects_itself or not self.steady else reduction.SteadyLoads(columns)


class _Selecting(Sized):
    select: Literal["lowest-frequency", "effective-interface-mass", "coupling-moment"] = Field(
        "lowest-frequency", description="the modes kept: the lowest, or those of largest interface motion"
    )
    candidates: int | None = Field(
        None, ge=1, description="lowest modes to select from; default: five times the number kept"
    )

    def build(self, *context: Any) -> reduction.CraigBampton:
        """The columns."""
        lowest = super().build(*context)
        candidates = self.candidates or max(CANDIDATES_PER_MODE * lowest.n_modes, 1)
        if self.select == "effective-interface-mass":
            return replace(lowest, selection=reduction.EffectiveInterfaceMass(candidates))
        if self.select == "coupling-moment":
            return replace(lowest, selection=reduction.CouplingMoment(candidates))
        return lowest


def _sized(makes: Any, basis: str, modes: str, least: int = 1, base: type[Sized] = Sized) -> Any:
    number: Any = Annotated[int, Field(ge=least)]
    first = Key(number | None, modes, "modes", None, through=lambda n: FIRST_MODES if n is None else n)
    return table_of(makes, basis, base, n_modes=first, n_columns=None, selection=None)


Rubin = _sized(reduction.Rubin, "rubin", "vibration modes, besides the attachment modes")
CraigBampton = _sized(
    reduction.CraigBampton,
    "craig-bampton",
    "fixed-interface modes, besides the constraint modes",
    least=0,
    base=_Selecting,
)
CraigBamptonResidual = _sized(
    reduction.CraigBamptonResidual,
    "craig-bampton-residual",
    "fixed-interface modes, besides the constraint and residual modes",
    least=0,
)
Herting = _sized(
    reduction.Herting,
    "herting",
    "free-interface modes, besides the constraint and inertia relief modes",
)
NormalModes = _sized(reduction.NormalModes, "normal-modes", "vibration modes")
Guyan = table_of(reduction.Guyan, "guyan", Correctable)
Complete = table_of(reduction.CompleteBasis, "complete", Correctable)


class ErrorControlledTable(Basis):
    """The lowest vibrations of the free body, each eigenvalue proven to be within a tolerance."""

    basis: Literal["error-controlled"]
    # The lower limit is due to round-off, as in supple.reduction.
    tolerance: float = Field(
        ge=1e-7, lt=1.0, description="largest relative error of the eigenvalues, such as 1e-3 for 0.1 %"
    )
    modes: int = Field(ge=1, description="number of lowest elastic eigenvalues within the tolerance")
    attachment_modes: bool = Field(
        True, description="false omits the static responses to forces at the interfaces"
    )
    derivatives: Derivatives | None = None
    condensed: bool | None = _CONDENSED

    def recipe(self, report: Report | None = None) -> LinearBasisRecipe:
        """The linear columns, whose number is found by a search."""
        progress = None if report is None else lambda step: report(search_words(step.n_modes, step.largest))
        vibrations = reduction.ErrorControlled(self.tolerance, self.modes, progress=progress)
        return reduction.AttachmentModes(vibrations) if self.attachment_modes else vibrations


Reduced = Correctable | ErrorControlledTable
_NEED_INTERFACES = (
    "rubin",
    "craig-bampton",
    "craig-bampton-residual",
    "herting",
    "guyan",
    "error-controlled",
)
Reduction = Annotated[
    Basis,
    OneOf(
        Rubin,
        CraigBampton,
        CraigBamptonResidual,
        Herting,
        NormalModes,
        Guyan,
        Complete,
        ErrorControlledTable,
        FullOrder,
        by="basis",
    ),
]


def reduction_start(
    given: Basis | None, body: FlexibleBody, quantity: QuantityOfInterest | None = None
) -> ReductionStart:
    """The initial basis and the target error of a body's self-correcting reduction.

    quantity : quantity whose error is limited; the positions of all nodes if None
    given : table of the reduction; None: Craig-Bampton, or normal modes for a body without interfaces
    """
    if given is None:
        given = CraigBampton(basis="craig-bampton") if body.interfaces else NormalModes(basis="normal-modes")
    assert isinstance(given, Correctable)  # other bases do not correct themselves
    derivatives = derivative_choice(given.derivatives)
    if given.derivatives is None and not body.is_linear:
        derivatives = reduction.CompressedDerivatives(FIRST_DERIVATIVES)
    accuracy = given.accuracy or Accuracy()
    start = ReductionStart(accuracy.target(quantity), given.recipe(), derivatives)
    return replace(start, quartic=quartic_choice(given.condensed, start.quartic))


def _bases_have_interfaces(path: KeyPath, body: Raw) -> Mistakes:
    """The rule that a body whose basis is one of `_NEED_INTERFACES` has an interface."""
    basis = table(body, "reduction").get("basis")
    if basis in _NEED_INTERFACES and is_elastic(body) and not names(body, "interface"):
        message = f'{basis} needs an interface; add [[body.interface]], or use basis = "normal-modes"'
        yield (*path, "reduction", "basis"), message


def _selections_have_candidates(path: KeyPath, body: Raw) -> Mistakes:
    """The rule that candidate modes need a selection, and are not fewer than the selected modes."""
    given = table(body, "reduction")
    candidates, modes, place = given.get("candidates"), given.get("modes"), (*path, "reduction", "candidates")
    if not isinstance(candidates, int):
        return
    if given.get("select", "lowest-frequency") == "lowest-frequency":
        yield (
            place,
            'the lowest modes are kept by default; remove the key, or add select = "coupling-'
            'moment" or "effective-interface-mass"',
        )
    if isinstance(modes, int) and modes > candidates:
        yield place, f"{modes} modes cannot be selected among {candidates} candidates; give more candidates"


def _sizes_are_fixed_or_corrected(path: KeyPath, body: Raw) -> Mistakes:
    """The rule that a reduction has a fixed size, or corrects itself with damping that full bodies allow."""
    given = table(body, "reduction")
    if not is_elastic(body) or "condense" in body or given.get("basis") in ("none", "error-controlled"):
        return  # of fixed size
    accuracy = given.get("accuracy")
    if {"relative", "absolute"} <= table(given, "accuracy").keys():
        message = "give the error either as relative or as absolute (a length), not both"
        yield (*path, "reduction", "accuracy", "absolute"), message
    sized = "modes" in given or given.get("basis") in ("guyan", "complete")
    if "derivatives" in given and not sized and accuracy is None:
        yield (
            (*path, "reduction", "derivatives"),
            "derivatives need modes = 10, for a basis of fixed size, or accuracy = {relative = 1e-3}, for a "
            "reduction that starts with these derivatives and corrects itself; add one of them",
        )
    if damps_all_modes(body) and (accuracy is not None or not sized):
        yield (
            (*path, "damping", "kind"),
            "a reduction that corrects itself takes rayleigh or rayleigh-ratio damping, or modal damping of "
            "modes = 10; or fix its size with modes = 10 and derivatives = {..}",
        )


def _nonlinear_options_have_strains(path: KeyPath, body: Raw) -> Mistakes:
    """The rule that modal derivatives need nonlinear strains, and modal damping of all modes a reduction."""
    given, kind = table(body, "reduction"), kind_of(body)
    linear = body.get("linear") is True or (kind is not None and kind.is_elastic and not kind.has_elements)
    if linear and table(given, "derivatives").get("kind") in ("compressed", "picked"):
        yield (*path, "reduction", "derivatives"), "a linear body has no modal derivatives; remove the key"
    if damps_all_modes(body) and given.get("basis") == "none":
        message = (
            "a body that is not reduced takes rayleigh or rayleigh-ratio damping, or modal damping of "
            "modes = 10"
        )
        yield (*path, "damping", "kind"), message


RULES_OF_BODY = (
    _bases_have_interfaces,
    _selections_have_candidates,
    _sizes_are_fixed_or_corrected,
    _nonlinear_options_have_strains,
)
