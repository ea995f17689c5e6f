"""Memory available to this process, checked before use, because the system ends a process that exceeds it."""

from __future__ import annotations

from pathlib import Path

from supple.errors import MemoryShortageError

_SYSTEM = Path("/proc/meminfo")
_GROUP = Path("/sys/fs/cgroup")
"""Folder with the memory limit of a container (cgroup version 2)."""


def available_memory() -> int | None:
    """Bytes available in the system, or the container; None if unknown."""
    left = [number for number in (_of_system(), _of_group()) if number is not None]
    return min(left, default=None)


def _of_system() -> int | None:
    try:
        lines = _SYSTEM.read_text(encoding="ascii").splitlines()
    except OSError:
        return None
    return next((1024 * int(line.split()[1]) for line in lines if line.startswith("MemAvailable:")), None)


def _of_group() -> int | None:
    try:
        limit = (_GROUP / "memory.max").read_text(encoding="ascii").strip()
        used = int((_GROUP / "memory.current").read_text(encoding="ascii"))
        counts = dict(map(str.split, (_GROUP / "memory.stat").read_text(encoding="ascii").splitlines()))
        # Inactive file contents in memory are released first when memory becomes short.
        used -= int(counts.get("inactive_file", 0))
    except (OSError, ValueError):
        return None
    return max(int(limit) - used, 0) if limit.isdigit() else None


def require_memory(needed: float, what: str, remedy: str) -> None:
    """Raise MemoryShortageError, with the purpose and a remedy, if the needed bytes are not available."""
    available = available_memory()
    if available is not None and needed > available:
        raise MemoryShortageError(
            f"{what} needs about {in_words(needed)} of memory, and {in_words(available)} are available: "
            f"{remedy}"
        )


def in_words(size: float) -> str:
    """A number of bytes, to two digits."""
    for unit in ("B", "kB", "MB", "GB"):
        if size < 999.5:
            return f"{size:.2g} {unit}" if size < 99.5 else f"{size:.0f} {unit}"
        size /= 1000
    return f"{size:.2g} TB" if size < 99.5 else f"{size:.0f} TB"
