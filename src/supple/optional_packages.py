"""Import of optional packages by the functions that need them, with an error message if one is missing."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType

from supple.errors import MissingPackageError


def optional_package(name: str, purpose: str, extra: str) -> ModuleType:
    """Import the package `name` and return it.

    purpose : use of the package, as the subject of the message, such as "an MP4 film"
    extra : optional dependency group of supple that installs it: pip install 'supple[EXTRA]'

    Raises MissingPackageError if it is not installed.
    """
    try:
        return import_module(name)
    except ModuleNotFoundError as error:
        raise MissingPackageError(
            f"{purpose} needs the package {name}, which is not installed: pip install 'supple[{extra}]'"
        ) from error
