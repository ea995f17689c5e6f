"""Errors and warnings: few, and each names what was seen, where, and what to do about it."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from difflib import get_close_matches


class SuppleError(Exception):
    """Base of every error that supple raises on purpose."""


class ArgumentError(SuppleError, ValueError, TypeError):
    """An argument of another kind than a function or constructor takes."""


class MeshError(SuppleError, ValueError):
    """A mesh that no method can use: NaN, inverted or degenerate cells, orphan nodes, empty sets."""


class CellError(MeshError):
    """A mesh with an unusable cell: inverted, flat, or naming a node twice.

    kind, number : the first such cell, by the name of its type and its number within the type
    """

    def __init__(self, message: str, kind: str, number: int) -> None:
        super().__init__(message)
        self.kind = kind
        self.number = number

    def __reduce__(self):
        return CellError, (str(self), self.kind, self.number)


class ImportFormatError(SuppleError, ValueError):
    """A file that breaks the rules of its format, or uses a part of it that is not supported."""


class ModelError(SuppleError, ValueError):
    """A material, section, interface, body or system whose data cannot describe a physical object."""


class AccuracyError(SuppleError, ArithmeticError):
    """A computed answer that fails its own check; the message carries the number."""


class ConvergenceError(SuppleError, RuntimeError):
    """An iteration that did not converge; the message names the time, the residual and the remedy."""


class ValidityError(SuppleError, RuntimeError):
    """A motion outside what the chosen kinematics can describe, under a strict validity check."""


class CaseError(SuppleError, ValueError):
    """A case file with mistakes; the message lists every one with its line and remedy."""


class ResultFileError(SuppleError, OSError):
    """A result file that cannot be read, written or continued."""


class MemoryShortageError(SuppleError, MemoryError):
    """Work that would not fit in the memory that is left; the message names its size and the remedy."""


class MissingPackageError(SuppleError, ModuleNotFoundError):
    """An optional package that is not installed; the message names it and how to install it."""


class ForkedProcessError(SuppleError, RuntimeError):
    """A simulation in a process that was forked after its parent had simulated."""


class SuppleWarning(UserWarning):
    """Base of every warning that supple issues."""


class ValidityWarning(SuppleWarning):
    """A motion near or beyond what the chosen kinematics can describe."""


class LockingWarning(SuppleWarning):
    """A reduced body answers too little, because its basis lacks stiff motion that bending needs."""


class BasisWarning(SuppleWarning):
    """A reduced body whose basis misses a part of its deformation at rest, or of a mode, that matters."""


class LoadSpectrumWarning(SuppleWarning):
    """Loads that excite modes which a reduced body lacks."""


class ControlWarning(SuppleWarning):
    """A machine that is analysed without the controllers that its case names."""


class UnitsWarning(SuppleWarning):
    """Numbers that are implausible in the units said of them."""


class RedundantConstraintWarning(SuppleWarning):
    """Joints that constrain the same motion twice; the redundant rows are named and left out."""


class StartWarning(SuppleWarning):
    """An initial state that the joints do not allow: it was changed, and by how much."""


class ResolutionWarning(SuppleWarning):
    """Time steps, or output times, too far apart for the loads, the prescribed motions or the motion."""


class IdentifiabilityWarning(SuppleWarning):
    """Parameters that were fitted to measurements which do not determine them."""


class UnlockedWarning(SuppleWarning):
    """A result on a file system that cannot keep other runs from writing it too."""


class StepCutWarning(SuppleWarning):
    """Time steps that are cut: for Newton's method to converge, or to keep to an error."""


def did_you_mean(name: str, known: Collection[str]) -> str:
    """How the message of an unknown name ends: with the nearest of the known names, or with all of them."""
    nearest = nearest_name(name, known)
    return f"; did you mean '{nearest}'?" if nearest else f"; there are: {', '.join(known) or 'none'}"


def nearest_name(name: str, known: Iterable[str]) -> str | None:
    """The known name that is spelled most like `name`, in either case; None when none is near."""
    by_lower = {candidate.lower(): candidate for candidate in known}
    for spelled in (name.lower().replace("_", "-"), name.lower()):
        if nearest := get_close_matches(spelled, by_lower, n=1):
            return by_lower[nearest[0]]
    return None
