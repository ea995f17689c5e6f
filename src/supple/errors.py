"""Errors and warnings, each with the cause, the location and the remedy."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from difflib import get_close_matches


class SuppleError(Exception):
    """Base of every error that supple raises on purpose."""


class ArgumentError(SuppleError, ValueError, TypeError):
    """An argument of a function, constructor or command with a wrong type or an invalid value."""


class MeshError(SuppleError, ValueError):
    """An unusable mesh: NaN, inverted or degenerate cells, orphan nodes, empty sets."""


class CellError(MeshError):
    """A mesh with an unusable cell: inverted, flat, or with a repeated node.

    kind, number : type of the first unusable cell, and its number within the type
    """

    def __init__(self, message: str, kind: str, number: int) -> None:
        super().__init__(message)
        self.kind = kind
        self.number = number

    def __reduce__(self):
        return CellError, (str(self), self.kind, self.number)


class ImportFormatError(SuppleError, ValueError):
    """A file that violates its format, or uses an unsupported part of it."""


class ModelError(SuppleError, ValueError):
    """A material, section, interface, body or system whose data cannot describe a physical object."""


class AccuracyError(SuppleError, ArithmeticError):
    """A result that fails a check of its accuracy; the message contains the deviation."""


class ConvergenceError(SuppleError, RuntimeError):
    """An iteration that did not converge; the message contains the time, the residual and the remedy."""


class ValidityError(SuppleError, RuntimeError):
    """A motion beyond the limits of the chosen kinematics, under a strict validity check."""


class CaseError(SuppleError, ValueError):
    """A case file with mistakes; the message lists every one with its line and remedy."""


class ResultFileError(SuppleError, OSError):
    """A result file that cannot be read, written or continued."""


class MemoryShortageError(SuppleError, MemoryError):
    """A computation that exceeds the available memory; the message contains its size and the remedy."""


class MissingPackageError(SuppleError, ModuleNotFoundError):
    """An optional package that is not installed; the message contains its name and how to install it."""


class ForkedProcessError(SuppleError, RuntimeError):
    """A simulation in a forked process whose parent had simulated before the fork."""


class SuppleWarning(UserWarning):
    """Base of every warning that supple issues."""


class ValidityWarning(SuppleWarning):
    """A motion near or beyond the limits of the chosen kinematics."""


class LockingWarning(SuppleWarning):
    """A reduced body whose static response is too small because its basis lacks stiff motion."""


class BasisWarning(SuppleWarning):
    """A reduced body whose basis lacks a significant part of its deformation, or of a mode."""


class LoadSpectrumWarning(SuppleWarning):
    """Loads that excite modes missing from a reduced body."""


class ControlWarning(SuppleWarning):
    """A machine analysed without the controllers of its case."""


class UnitsWarning(SuppleWarning):
    """Numbers that are implausible in their units."""


class RedundantConstraintWarning(SuppleWarning):
    """Redundant constraints of joints; the redundant rows are reported and left out."""


class StartWarning(SuppleWarning):
    """An initial state that violates the joints and was corrected."""


class ResolutionWarning(SuppleWarning):
    """Time steps, or output times, too far apart for the loads, the prescribed motions or the response."""


class IdentifiabilityWarning(SuppleWarning):
    """Fitted parameters that the measurements do not determine."""


class UnlockedWarning(SuppleWarning):
    """A result on a file system without locks, where other runs could write it too."""


class StepCutWarning(SuppleWarning):
    """Time steps that were shortened, for Newton's method to converge or for the error tolerance."""


def did_you_mean(name: str, known: Collection[str]) -> str:
    """End of the message for an unknown name: the most similar known name, or all if none is similar."""
    nearest = nearest_name(name, known)
    return f"; did you mean '{nearest}'?" if nearest else f"; there are: {', '.join(known) or 'none'}"


def nearest_name(name: str, known: Iterable[str]) -> str | None:
    """The known name with the most similar spelling, ignoring case; None if no name is similar."""
    by_lower = {candidate.lower(): candidate for candidate in known}
    for spelled in (name.lower().replace("_", "-"), name.lower()):
        if nearest := get_close_matches(spelled, by_lower, n=1):
            return by_lower[nearest[0]]
    return None
