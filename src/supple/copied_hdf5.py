"""HDF5 files of unknown origin, copied by a separate process before they are read.

On a damaged file the HDF5 library may hang, take all memory, or crash the process. Here only the copying
process is affected; the caller reads the new file. Files with a seal (`file_seal`) are read directly.

Limits of the copying process: 15 s of processor time, plus 1 s per 50 MB of the file; 2 GiB of memory, or
twenty times the size of the file if this is more. No array may be larger than twenty times the file.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path

import h5py

from supple.other_processes import python_command, python_environment

SECONDS = 15.0
_BYTES_PER_SECOND = 50e6
_WAITING = 4
"""Ratio of the limit of the elapsed time to that of the processor time; large enough for a busy computer."""
MEMORY = 2 * 2**30
_TIMES_ITS_SIZE = 20

_OUT_OF_TIME = -getattr(signal, "SIGXCPU", 24)
"""Exit code of a process that exceeds its time."""
_EXPLAINED = 3
"""Exit code of a process that reports an error."""


@contextmanager
def open_copied(path: Path, parts: Collection[str] | None = None) -> Iterator[h5py.File]:
    """Open an uncompressed copy of an HDF5 file: arrays with text attributes, groups with all attributes.

    parts : names of the members of the root to copy; by default all. Missing names are skipped, links are
        followed.

    Raises
    ------
    OSError     HDF5 reports an error, exceeds its time or memory limit, or crashes
    """
    with tempfile.TemporaryDirectory(prefix="supple-") as folder:
        copy = Path(folder) / "copy.h5"
        _copy_apart(path, copy, parts)
        with h5py.File(copy, "r", locking=False) as file:
            yield file


def _copy_apart(path: Path, copy: Path, parts: Collection[str] | None) -> None:
    size = path.stat().st_size
    seconds = SECONDS + size / _BYTES_PER_SECOND
    memory = max(MEMORY, _TIMES_ITS_SIZE * size)
    # An empty collection copies only the root's attributes; "/" copies everything.
    words = [path.absolute(), copy, seconds, memory, *(["/"] if parts is None else parts)]
    too_long = OSError(f"HDF5 does not finish within {seconds:.0f} s, the limit")
    try:
        done = subprocess.run(
            python_command(__file__, *(str(word) for word in words)),
            env=python_environment(),
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=_WAITING * seconds,
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise too_long from error
    if done.returncode == _EXPLAINED:
        raise OSError(done.stdout.decode(errors="replace").strip())
    if done.returncode == _OUT_OF_TIME:
        raise too_long
    if done.returncode:
        raise OSError(f"HDF5 crashes on this file (exit code {done.returncode})")


def copy_within_limits(path: str, copy: str, seconds: str, memory: str, *parts: str) -> int:
    """Limit the time and memory of this process, copy the parts in it, and return its exit code."""
    _limit(float(seconds), int(memory))
    try:
        with h5py.File(path, "r", locking=False) as source, h5py.File(copy, "w") as target:
            _copy_group(source, target, list(source) if parts == ("/",) else parts)
    # Any error is passed to the parent process.
    except Exception as error:
        sys.stdout.write(str(error) or type(error).__name__)
        return _EXPLAINED
    return 0


def _copy_group(source: h5py.Group, target: h5py.Group, names: Collection[str]) -> None:
    for name, value in source.attrs.items():
        target.attrs[name] = value
    for name in names:
        found = source.get(name)
        match found:
            case h5py.Dataset():
                _check_size(found)
                made = target.create_dataset(name, data=found[()], dtype=found.dtype)
                for key in found.attrs:
                    if h5py.check_string_dtype(found.attrs.get_id(key).dtype):
                        made.attrs[key] = found.attrs[key]
            case h5py.Group():
                _copy_group(found, target.create_group(name), list(found))


def _check_size(found: h5py.Dataset) -> None:
    claimed, limit = found.size * found.dtype.itemsize, _TIMES_ITS_SIZE * found.file.id.get_filesize()
    if claimed > limit:
        raise ValueError(
            f"{found.name} should have {claimed} bytes; the limit for a file of this size is {limit}"
        )


def _limit(seconds: float, memory: int) -> None:
    try:
        import resource  # not on Windows
    except ImportError:
        return
    statm = Path("/proc/self/statm")
    pages = int(statm.read_text(encoding="ascii").split()[0]) if statm.exists() else 0
    for kind, most in (
        (resource.RLIMIT_AS, pages * resource.getpagesize() + memory),
        (resource.RLIMIT_CPU, max(1, round(seconds))),
        (resource.RLIMIT_CORE, 0),
    ):
        allowed = resource.getrlimit(kind)[1]
        resource.setrlimit(kind, (most if allowed < 0 else min(most, allowed), allowed))


if __name__ == "__main__":
    status = copy_within_limits(*sys.argv[1:])
    sys.stdout.flush()
    # Without the cleanup of HDF5, which may fail on damaged data.
    os._exit(status)
