"""Libraries of linear machines, built once for all platforms: exporting such a machine needs no compiler.

The folder `prebuilt` of the package is filled when a release is built; a checkout compiles at each export.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from importlib import resources

from supple.export.fmu.platforms import PLATFORMS, Platform

__all__ = ["FOLDER", "prebuilt_libraries", "prebuilt_path"]

FOLDER = resources.files("supple.export.fmu").joinpath("prebuilt")


def prebuilt_path(sources: Mapping[str, str], platform: Platform, fmi: int) -> str:
    """Name of a library in `FOLDER`, with the digest of its sources: a stale one is not found."""
    texts = "\0".join(f"{name}\0{text}" for name, text in sorted(sources.items()))
    digest = hashlib.sha256(texts.encode()).hexdigest()[:16]
    return f"{digest}-{platform.folders[fmi]}{platform.suffix}"


def prebuilt_libraries(
    sources: Mapping[str, str], fmi: int, platforms: tuple[Platform, ...]
) -> list[tuple[Platform, bytes]]:
    """Libraries of these sources for the platforms, by default all that exist; none if one is missing."""
    every = [each for of_system in PLATFORMS.values() for each in of_system]
    wanted = [each for each in platforms or every if fmi in each.folders]
    files = [(each, FOLDER.joinpath(prebuilt_path(sources, each, fmi))) for each in wanted]
    found = [(each, file.read_bytes()) for each, file in files if file.is_file()]
    return [] if platforms and len(found) < len(wanted) else found
