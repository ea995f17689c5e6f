"""JAX's process-wide settings: the effects of importing a compiled part of supple on a process.

- 64-bit floats (`jax_enable_x64`): lengths of a blade and strains of a millionth occur in one equation.
- One thread (`NPROC`): a compiled step is hundreds of operations shorter than a microsecond, and passing them
  between threads takes longer than computing them. JAX reads `NPROC` when it starts; an earlier setting is
  kept.
- A process forked after compiled code has run refuses to run more (`check_not_forked`): JAX's threads do not
  survive a fork, and the child would wait for them for ever.
- Loops become functions of machine code (`XLA_FLAGS`), as XLA otherwise interprets a list of operations one
  by one. A program is one piece of machine code, as one thread compiles it. JAX reads `XLA_FLAGS` when it
  starts; earlier settings are kept.
- Compiled programs of any size are cached between processes: in the folder of JAX_COMPILATION_CACHE_DIR, or
  in the user's cache, unless another folder was set before.
- Compiled programs are released before a process reaches a limit (`bound_programs`): Linux limits the number
  of memory maps of a process, a program uses several, and beyond the limit the compiler ends the process.
"""

from __future__ import annotations

import ctypes
import gc
import hashlib
import os
import platform
from collections.abc import Callable
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path

import jax

from supple.algebra.available_memory import available_memory
from supple.errors import ForkedProcessError


def keep_compiled_programs(folder: Path | None = None) -> Path | None:
    """Store compiled programs in a folder, by default the user's cache; returns the folder.

    A user without a home folder has no cache: nothing is stored, and None is returned.

    A program is identified by its content, so a stale one is never used; the folder may be deleted at any
    time. Programs are native code: the name of the default folder contains the processor and the versions of
    JAX, which separates different machines with a shared home. JAX_COMPILATION_CACHE_DIR of the environment
    takes precedence; JAX_ENABLE_COMPILATION_CACHE=false turns the cache off.
    """
    named = os.environ.get("JAX_COMPILATION_CACHE_DIR")
    folder = Path(named) if named else folder or _user_folder()
    if folder is None:
        return None
    jax.config.update("jax_compilation_cache_dir", str(folder))
    # Store small programs as well: there are hundreds, and reading one takes a sixth of its compilation.
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
    return folder


def _user_folder() -> Path | None:
    """Folder of this machine's programs in the user's cache; None without a home folder."""
    found = (os.environ.get(variable) for variable in ("XDG_CACHE_HOME", "LOCALAPPDATA"))
    try:
        cache = next((Path(each) for each in found if each), None) or Path.home() / ".cache"
    except RuntimeError:  # no HOME, and no entry of the user in the system's list
        return None
    return cache / "supple" / "compiled" / this_machine()


@lru_cache
def this_machine() -> str:
    """Key of all that native code depends on: architecture, instruction sets, versions."""
    features = [
        platform.system(),
        platform.machine(),
        platform.processor(),
        version("jax"),
        version("jaxlib"),
    ]
    listing = Path("/proc/cpuinfo")
    if listing.exists():
        lines = listing.read_text(encoding="utf-8", errors="replace").splitlines()
        wanted = ("model name", "flags", "Features", "CPU part")
        features += sorted({line for line in lines if line.startswith(wanted)})
    return f"{platform.machine()}-{hashlib.sha256(repr(features).encode()).hexdigest()[:12]}"


class _Process:
    """State of this process that a forked child inherits."""

    computed = False
    forked_after_computing = False
    compiled_since_looked = 0
    """Programs built since the memory maps were last counted."""
    held = 0
    """Programs built since all were last released."""


def _remember_fork() -> None:
    _Process.forked_after_computing = _Process.computed


def check_not_forked() -> None:
    """Raise ForkedProcessError, before compiled code runs, in a process where it would never return."""
    if _Process.forked_after_computing:
        raise ForkedProcessError(
            "this process was forked from one that had simulated already, and JAX does not work in such a "
            'child: start workers with multiprocessing.get_context("spawn"), or fork before the first run'
        )
    _Process.computed = True


_MAPS = Path("/proc/self/maps")
_MOST_MAPS = Path("/proc/sys/vm/max_map_count")
_PAGES = Path("/proc/self/statm")
_LOOK_EVERY = 64
"""Number of new programs after which the memory maps are counted again: a count takes milliseconds, and no
program uses a hundred maps."""

_WORTH_RELEASING = 1000
"""Fewest programs, of 1 to 2 MB each: fewer do not fill the memory, and take a minute to compile again."""


def bound_programs() -> bool:
    """Release all compiled programs of a Linux process if there are too many; returns whether it did.

    There are too many if the process uses two thirds of the memory maps that the system allows. A thousand
    programs are also too many if the process uses more memory than is still available. A later run reads its
    programs from the cache folder, or compiles them again.
    """
    if _Process.compiled_since_looked < _LOOK_EVERY or not _MAPS.exists():
        return False
    _Process.compiled_since_looked = 0
    if not (_maps_run_out() or (_Process.held >= _WORTH_RELEASING and _memory_runs_out())):
        return False
    release_programs()
    return True


def _maps_run_out() -> bool:
    with _MAPS.open("rb") as listing:
        count = sum(1 for _ in listing)
    return 3 * count >= 2 * int(_MOST_MAPS.read_text())


def _memory_runs_out() -> bool:
    available = available_memory()
    resident = int(_PAGES.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    return available is not None and resident > available


def release_programs() -> None:
    """Release all compiled programs, and return their memory to the system; the counts start again."""
    _Process.compiled_since_looked = _Process.held = 0
    jax.clear_caches()
    for forget in _FORGET:
        forget()
    gc.collect()
    # The C library of Linux keeps freed memory: a gigabyte after a thousand programs.
    if _MAPS.exists() and (trim := getattr(ctypes.CDLL(None), "malloc_trim", None)):
        trim(0)


_FORGET: list[Callable[[], None]] = []


def on_program_release(forget: Callable[[], None]) -> None:
    """Register a function that releases programs unknown to JAX, called by `release_programs`."""
    _FORGET.append(forget)


def before_compiled_code() -> None:
    """Checks before a process runs more compiled code."""
    check_not_forked()
    bound_programs()


def count_program() -> None:
    """Count one more program in the process."""
    _Process.compiled_since_looked += 1
    _Process.held += 1


def _listen(event: str, duration_secs: float, **kwargs: object) -> None:  # noqa: ARG001
    if event == "/jax/core/compile/backend_compile_duration":
        count_program()


jax.monitoring.register_event_duration_secs_listener(_listen)
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_remember_fork)


def _writable(folder: Path | None) -> bool:
    """Whether programs can be cached there: a home may be missing or read-only."""
    if folder is None:
        return False
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return False
    return os.access(folder, os.W_OK)


_FLAGS = {
    # Largest loop body in bytes; only loops over large meshes exceed it, and these lose nothing.
    "--xla_backend_extra_options": "xla_cpu_small_while_loop_byte_threshold=1000000000",
    # No library for products of small matrices: its call prevents a loop from being a function.
    "--xla_cpu_experimental_ynn_fusion_type": "",
    # A program in 32 pieces takes a quarter longer to compile, and twice the memory maps.
    "--xla_cpu_parallel_codegen_split_count": "1",
}
"""JAX ends a process with an unknown flag: all versions that the package allows support these."""


def _with_flags(given: str) -> str:
    """XLA_FLAGS with those for compiled runs; flags already set are kept."""
    own = [f"{name}={value}" for name, value in _FLAGS.items() if name not in given]
    return " ".join([given, *own]).strip()


jax.config.update("jax_enable_x64", True)
os.environ.setdefault("NPROC", "1")
os.environ["XLA_FLAGS"] = _with_flags(os.environ.get("XLA_FLAGS", ""))
# Also called for a folder from the environment: by default JAX caches nothing compiled within a second.
if os.environ.get("JAX_COMPILATION_CACHE_DIR") or (
    getattr(jax.config, "jax_compilation_cache_dir", None) is None and _writable(_user_folder())
):
    keep_compiled_programs()
