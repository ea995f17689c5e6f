"""Warnings of checks, which are errors in a strict run."""

from __future__ import annotations

import warnings

from supple.errors import SuppleWarning, ValidityError
from supple.integrate import Validity


def warn_or_raise(message: str, category: type[SuppleWarning], validity: Validity) -> None:
    """Warn; in a strict run raise ValidityError instead."""
    if validity.strict:
        raise ValidityError(message)
    warnings.warn(message, category, stacklevel=4)
