"""Prebuilt FMU libraries for linear machines, with which their export needs no compiler.

The folder `prebuilt` of the package is filled when a release is built. A source checkout compiles the library
at each export.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from importlib import resources

from supple.export.fmu.platforms import EVERY_PLATFORM, Platform

FOLDER = resources.files("supple.export.fmu").joinpath("prebuilt")


def prebuilt_path(sources: Mapping[str, str], platform: Platform, fmi: int) -> str:
    """Name of a library in `FOLDER`, with a digest of its sources, so that old libraries do not match."""
    texts = "\0".join(f"{name}\0{text}" for name, text in sorted(sources.items()))
    digest = hashlib.sha256(texts.encode()).hexdigest()[:16]
    return f"{digest}-{platform.folders[fmi]}{platform.suffix}"


def prebuilt_libraries(
    sources: Mapping[str, str], fmi: int, platforms: tuple[Platform, ...]
) -> list[tuple[Platform, bytes]]:
    """Libraries for the given platforms, none if one is missing; by default all prebuilt libraries."""
    wanted = [each for each in platforms or EVERY_PLATFORM if fmi in each.folders]
    files = [(each, FOLDER.joinpath(prebuilt_path(sources, each, fmi))) for each in wanted]
    found = [(each, file.read_bytes()) for each, file in files if file.is_file()]
    return [] if platforms and len(found) < len(wanted) else found
