"""Cache of compiled programs, found by the structure of their arguments without tracing or compilation.

JAX's own cache is searched by the text of a program, and writing that text takes longer than reading many
programs. Here the key is the digest of everything a program depends on (`program_digest`), which is known
before tracing. After a change of the sources the text is the key, so that a program stays valid under all
changes that do not affect it.
"""

from __future__ import annotations

import gc
import os
import pickle
import zlib
from collections import OrderedDict
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import lru_cache, partial
from itertools import count
from pathlib import Path
from stat import S_ISREG
from types import MappingProxyType
from typing import Any

import jax
import numpy as np
from jax.core import Tracer
from jax.experimental import serialize_executable
from jax.stages import Compiled
from jax.tree_util import PyTreeDef

from supple.algebra.jax_settings import count_program, on_program_release
from supple.programs.program_digest import digest_of_sources, program_digest, text_digest
from supple.programs.program_worker import program_of_file

Arguments = tuple[Any, ...]
"""Pytrees of arrays"""
LeafType = tuple[tuple[int, ...], str, bool]
"""Shape and type of an array or number, and whether the type is weak (other operands determine it)"""
Shapes = tuple[LeafType, ...]
Signature = tuple[PyTreeDef, Shapes]

_MOST_AT_HAND = 16
"""Largest number of programs of one function in memory; the least recently used is released first."""


class CachedProgram:
    """A function of arrays, compiled once for all arguments that differ in numbers only.

    function : with pytrees as positional arguments; returns arrays in tuples and named tuples
    """

    def __init__(
        self, function: Callable[..., Any], options: Mapping[str, Any] = MappingProxyType({})
    ) -> None:
        self.function = function
        self._options = dict(options)
        self._at_hand: OrderedDict[Signature, Compiled] = OrderedDict()
        on_program_release(self._at_hand.clear)

    def __call__(self, *arguments: Any) -> Any:
        """The function's result; while another program is traced, the function becomes part of it."""
        if any(isinstance(leaf, Tracer) for leaf in jax.tree.leaves(arguments)):
            return self.function(*arguments)
        return self.compiled(*arguments)(*arguments)

    def compiled(self, *arguments: Any) -> Compiled:
        """The compiled program for arguments of the same structure.

        In one process, functions in the structure are compared by identity: a later change of the values that
        a function reads from its module or closure has no effect.
        """
        key = self.signature(*arguments)
        if key not in self._at_hand:
            with _no_garbage_collected():
                self._at_hand[key] = self._found_or_built(arguments, *key)
            if len(self._at_hand) > _MOST_AT_HAND:
                self._at_hand.popitem(last=False)
        self._at_hand.move_to_end(key)
        return self._at_hand[key]

    def file(self, *arguments: Any) -> Path | None:
        """File of the program for arguments of this structure (`program_of_file`); None without a cache."""
        known = self._known(*self.signature(*arguments))
        return None if known is None else _named_by(known)

    @staticmethod
    def signature(*arguments: Any) -> Signature:
        """Structure of the arguments, and shapes and types of their arrays: the key of a program."""
        leaves, structure = jax.tree.flatten(arguments)
        return structure, tuple(map(_type_of, leaves))

    def _found_or_built(self, arguments: Arguments, structure: PyTreeDef, shapes: Shapes) -> Compiled:
        known = self._known(structure, shapes)
        if known is None:
            return jax.jit(self.function).lower(*arguments).compile(compiler_options=self._options)
        taken = jax.tree.structure((arguments, {}))
        file = _named_by(known)
        found = _read(file, taken) if file else None
        return found or self._by_text(arguments, shapes, known, taken)

    def _known(self, structure: PyTreeDef, shapes: Shapes) -> Path | None:
        """File that maps this structure to the text of its program; None without a cache."""
        folder = _folder()
        digest = program_digest(self.function, self._options, structure, shapes) if folder else None
        if folder is None or digest is None:
            return None
        return folder / "by-structure" / digest_of_sources()[:16] / digest

    def _by_text(self, arguments: Arguments, shapes: Shapes, known: Path, taken: PyTreeDef) -> Compiled:
        """The program found by its text, or compiled; its structure is then stored as a key."""

        def kept(*arguments: Any) -> Any:
            return self.function(*arguments)

        # A name that JAX's cache does not contain: a program read from that cache cannot be serialised again.
        named = self.function.func if isinstance(self.function, partial) else self.function
        kept.__name__ = f"kept_{named.__name__.lstrip('_')}"  # ty: ignore[missing-attribute]
        lowered = jax.jit(kept).lower(*arguments)
        # The text leaves out unused arguments, but the compiled program expects all of them.
        text = text_digest(f"{shapes}\n{lowered.as_text()}", self._options)
        file = _by_its_text(known, text)
        program = _read(file, taken)
        if program is None:
            with _not_kept_by_jax():
                program = lowered.compile(compiler_options=self._options)
            _write(file, program)
            _make_room(known.parents[2])
        if _exists(file):
            _replace(known, text.encode("ascii"))
        return program


def _type_of(leaf: Any) -> LeafType:
    if isinstance(leaf, np.ndarray):  # ten times faster than JAX's own description
        return leaf.shape, _name(leaf.dtype), False
    own = jax.typeof(leaf)
    return own.shape, _name(own.dtype), own.weak_type


@lru_cache
def _name(dtype: Any) -> str:
    return str(jax.dtypes.canonicalize_dtype(dtype))


_MOST_KEPT = 2**30
"""Largest size of the cache folder, bytes: some thousand programs, of hundreds of machines."""


@lru_cache
def _make_room(folder: Path) -> None:
    """Delete the least recently read programs where the folder is too large; once per process.

    JAX's own programs are included. Another process that needs a deleted program compiles it again.
    """
    files = []
    with suppress(OSError):  # the folder may not be searched, or another process deletes it
        for file in folder.rglob("*"):
            with suppress(OSError):
                status = file.stat()
                if S_ISREG(status.st_mode):
                    files.append((max(status.st_atime, status.st_mtime), status.st_size, file))
    size = sum(each for _, each, _ in files)
    for _, own, file in sorted(files):
        if size <= _MOST_KEPT:
            return
        size -= own
        with suppress(OSError):
            file.unlink()


def _by_its_text(known: Path, text: str) -> Path:
    return known.parents[2] / "by-text" / text


def _named_by(known: Path) -> Path | None:
    """The file of a program with a known structure; None where it does not exist."""
    try:
        file = _by_its_text(known, known.read_text("ascii"))
    except OSError:
        return None
    return file if _exists(file) else None


def _exists(file: Path) -> bool:
    """Whether a file exists, and its folder may be searched."""
    try:
        return file.exists()
    except OSError:
        return False


def _folder() -> Path | None:
    """The cache folder; None without a cache."""
    folder = getattr(jax.config, "jax_compilation_cache_dir", None)
    enabled = getattr(jax.config, "jax_enable_compilation_cache", True)
    if folder is None or not enabled or jax.default_backend() != "cpu":
        return None
    return Path(folder)


@contextmanager
def _no_garbage_collected() -> Iterator[None]:
    """Disable garbage collection, which takes a tenth of the time of tracing and would find no garbage."""
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()


@contextmanager
def _not_kept_by_jax() -> Iterator[None]:
    name = "jax_persistent_cache_min_compile_time_secs"
    before = getattr(jax.config, name)
    jax.config.update(name, float("inf"))
    try:
        yield
    finally:
        jax.config.update(name, before)


def _read(file: Path, taken: PyTreeDef) -> Compiled | None:
    """A cached program for arguments of a structure, or None."""
    if not _exists(file):
        return None
    try:
        found = program_of_file(file, taken)
    except Exception:
        return None
    count_program()
    return found


def _write(file: Path, program: Compiled) -> None:
    """Write a program to the cache, if possible."""
    try:
        content, _, of_result = serialize_executable.serialize(program)
        result = jax.tree.unflatten(of_result, range(of_result.num_leaves))
        _replace(file, zlib.compress(pickle.dumps(content) + pickle.dumps(result), 1))
    except (ValueError, TypeError, AttributeError, pickle.PicklingError, jax.errors.JaxRuntimeError):
        return


def _replace(file: Path, content: bytes) -> None:
    """Write a file atomically; nothing is written where the folder does not allow it."""
    temporary = file.with_name(f"{file.name}.{os.getpid()}-{next(_NUMBER)}")
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        temporary.write_bytes(content)
        temporary.replace(file)
    except OSError:
        with suppress(OSError):  # a file system may be read-only
            temporary.unlink(missing_ok=True)


_NUMBER = count()
