"""Keep compiled programs between runs: the second run of a case starts at once."""

from __future__ import annotations

import os
from pathlib import Path

import jax

__all__ = ["keep_compiled_programs"]


def keep_compiled_programs(folder: Path | None = None) -> Path:
    """Store compiled programs in a folder, by default the user's cache; returns the folder.

    A program is found again by its content, so a stale one is never used; the folder may be deleted at any
    time. The JAX_COMPILATION_CACHE_DIR of the environment takes precedence.
    """
    named = os.environ.get("JAX_COMPILATION_CACHE_DIR")
    folder = Path(named) if named else folder or _user_cache() / "supple" / "compiled"
    jax.config.update("jax_compilation_cache_dir", str(folder))
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.2)
    return folder


def _user_cache() -> Path:
    for variable in ("XDG_CACHE_HOME", "LOCALAPPDATA"):
        if os.environ.get(variable):
            return Path(os.environ[variable])
    return Path.home() / ".cache"
