"""Platforms for which an FMU contains a library, and the compiler for each."""

from __future__ import annotations

import importlib.util
import os
import platform
import shutil
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from supple.errors import ModelError


@dataclass(frozen=True)
class Platform:
    """An operating system on a processor.

    folders : folder of the library in an FMU, by version of FMI
    target : name of the platform for the cross-compiler, with the oldest C library on which the library runs
    """

    folders: Mapping[int, str]
    suffix: str
    target: str


_LINUX = Platform(MappingProxyType({2: "linux64", 3: "x86_64-linux"}), ".so", "x86_64-linux-gnu.2.17")
_LINUX_ARM = Platform(MappingProxyType({3: "aarch64-linux"}), ".so", "aarch64-linux-gnu.2.17")
_WINDOWS = Platform(MappingProxyType({2: "win64", 3: "x86_64-windows"}), ".dll", "x86_64-windows-gnu")
_MACOS = Platform(MappingProxyType({2: "darwin64", 3: "x86_64-darwin"}), ".dylib", "x86_64-macos.11.0")
_MACOS_ARM = Platform(MappingProxyType({3: "aarch64-darwin"}), ".dylib", "aarch64-macos.11.0")

PLATFORMS: Mapping[str, tuple[Platform, ...]] = MappingProxyType(
    {"linux": (_LINUX, _LINUX_ARM), "windows": (_WINDOWS,), "macos": (_MACOS, _MACOS_ARM)}
)
"""Platforms by the name of the operating system."""


EVERY_PLATFORM = tuple(each for of_system in PLATFORMS.values() for each in of_system)


@dataclass(frozen=True)
class Compiler:
    """A compiler of libraries for one platform.

    command : compiler, with the options that select the platform
    """

    platform: Platform
    command: tuple[str, ...]


def compilers_of(platforms: tuple[Platform, ...], fmi: int) -> tuple[Compiler, ...]:
    """Compilers for those of the given platforms that a version of FMI defines; by default for this computer.

    Raises ModelError: no compiler for this computer, or no cross-compiler for the given platforms.
    """
    if not platforms:
        return (Compiler(_this_one(fmi), (_own_compiler(),)),)
    if importlib.util.find_spec("ziglang") is None:
        raise ModelError("libraries for given platforms need a cross-compiler: pip install 'supple[fmu]'")
    zig = (sys.executable, "-m", "ziglang", "cc", "-fno-sanitize=undefined", "-s")
    return tuple(Compiler(each, (*zig, "-target", each.target)) for each in platforms if fmi in each.folders)


def _this_one(fmi: int) -> Platform:
    found = {"x86_64": _LINUX, "aarch64": _LINUX_ARM}.get(platform.machine())
    if not sys.platform.startswith("linux") or found is None or fmi not in found.folders:
        raise ModelError(
            f"the compiler of {sys.platform} {platform.machine()} is not used for FMUs of FMI {fmi}: name "
            f"platforms ({', '.join(PLATFORMS)}), or export the machine as C (--c FOLDER) and build it there"
        )
    return found


def _own_compiler() -> str:
    compiler = os.environ.get("CC") or shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        raise ModelError(
            "an FMU needs a C compiler: install one (gcc, clang), name it in the variable CC, or name "
            f"platforms ({', '.join(PLATFORMS)}) for the cross-compiler of supple[fmu]"
        )
    return compiler
