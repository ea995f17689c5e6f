"""Optional packages, loaded by the functions that need them, with a message if missing."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType

from supple.errors import MissingPackageError


def optional_package(name: str, purpose: str, extra: str) -> ModuleType:
    """The package of that name.

    purpose : description of its use
    extra : extra of supple that installs it

    Raises MissingPackageError if it is not installed.
    """
    try:
        return import_module(name)
    except ModuleNotFoundError as error:
        raise MissingPackageError(
            f"{purpose} needs the package {name}, which is not installed: pip install 'supple[{extra}]'"
        ) from error
