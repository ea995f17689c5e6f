"""Kept programs read from their files, here and by a process that runs one for this one.

As a script it is that process (`worker_processes`). It needs JAX and nothing of supple: it is ready in the
time that JAX takes to be imported. Its input states the file of the program, the numbers of arrays
that go in and come out, and then arguments; by its output it answers with seconds and results. It ends with
its input.
"""

from __future__ import annotations

import io
import os
import pickle
import signal
import sys
import zlib
from functools import lru_cache
from pathlib import Path
from time import perf_counter
from typing import Any, BinaryIO

import jax
import numpy as np
from jax.experimental import serialize_executable
from jaxlib.lapack import prepare_lapack_call

__all__ = ["program_of_file"]


def program_of_file(file: Path, taken: Any, given: Any = None) -> Any:
    """The compiled program that a file holds, for one processor.

    It holds, compressed, two pickled objects: the program as JAX writes it, and a pytree like its result.

    taken : structure of the arguments
    given : structure of the result; that of the file's second object where left out
    """
    _bind_lapack()
    content = io.BytesIO(zlib.decompress(file.read_bytes()))
    program = pickle.load(content)
    if given is None:
        given = jax.tree.structure(pickle.load(content))
    # By default for all processors that JAX has.
    devices = jax.devices()[:1]
    return serialize_executable.deserialize_and_load(program, taken, given, execution_devices=devices)


@lru_cache
def _bind_lapack() -> None:
    """Have JAX find the routines of LAPACK, which it does only as it writes a program that calls one."""
    prepare_lapack_call("getrf", np.dtype(float))


def answer(questions: BinaryIO, answers: BinaryIO) -> None:
    """Run the program for all that is asked."""
    file, n_arguments, n_results = pickle.load(questions)
    taken = jax.tree.structure((tuple(range(n_arguments)), {}))
    program = program_of_file(Path(file), taken, jax.tree.structure(list(range(n_results))))
    _say("ready", answers)
    while True:
        try:
            arguments = pickle.load(questions)
        except EOFError:
            return
        began = perf_counter()
        found = [np.asarray(each) for each in jax.device_get(program(*arguments))]
        _say((perf_counter() - began, found), answers)


def _say(answered: Any, answers: BinaryIO) -> None:
    pickle.dump(answered, answers, pickle.HIGHEST_PROTOCOL)
    answers.flush()


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # of the process that asks, which closes the input
    with os.fdopen(os.dup(sys.stdout.fileno()), "wb") as own:
        os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # whatever libraries say
        answer(sys.stdin.buffer, own)
