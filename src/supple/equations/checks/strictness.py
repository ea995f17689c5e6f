"""How a check speaks: by a warning, or by an error where the run is strict."""

from __future__ import annotations

import warnings

from supple.errors import SuppleWarning, ValidityError
from supple.integrate import Validity

__all__ = ["say"]


def say(message: str, category: type[SuppleWarning], validity: Validity) -> None:
    """Warn; raise ValidityError instead when strict."""
    if validity.strict:
        raise ValidityError(message)
    warnings.warn(message, category, stacklevel=4)
