"""Packages that only some functions need: loaded by these, and named where they are missing."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType

from supple.errors import MissingPackageError


def optional_package(name: str, purpose: str, extra: str) -> ModuleType:
    """The package of that name.

    purpose : what is made by it, in words
    extra : of supple, that installs it

    Raises MissingPackageError where it is not installed.
    """
    try:
        return import_module(name)
    except ModuleNotFoundError as error:
        raise MissingPackageError(
            f"{purpose} is made by the package {name}, which is not installed: pip install 'supple[{extra}]'"
        ) from error
