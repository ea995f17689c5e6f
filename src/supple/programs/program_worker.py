"""Reads cached programs from their files; run as a script, executes one program for another process.

The script is the worker process of `worker_processes`. It imports JAX and nothing of supple, so that it is
ready as soon as JAX is imported. Its input is the file of the program, the numbers of input and output
arrays, and then arguments; its output is the time in seconds and the results. It ends when its input ends.
"""

from __future__ import annotations

import io
import os
import pickle
import signal
import sys
import zlib
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from time import perf_counter
from typing import Any, BinaryIO

import jax
import numpy as np
from jax.experimental import serialize_executable
from jax.stages import Compiled
from jax.tree_util import PyTreeDef
from jaxlib.lapack import prepare_lapack_call


def program_of_file(file: Path, taken: PyTreeDef, given: PyTreeDef | None = None) -> Compiled:
    """The compiled program in a file, for one processor.

    The file contains, compressed, two pickled objects: the program as serialised by JAX, and a pytree with
    the structure of its result.

    taken : structure of the arguments
    given : structure of the result; None: the structure of the second object in the file
    """
    _bind_lapack()
    content = io.BytesIO(zlib.decompress(file.read_bytes()))
    program = pickle.load(content)
    if given is None:
        given = jax.tree.structure(pickle.load(content))
    # The default would be all processors that JAX has.
    devices = jax.devices()[:1]
    return serialize_executable.deserialize_and_load(program, taken, given, execution_devices=devices)


@lru_cache
def _bind_lapack() -> None:
    """Register the LAPACK routines with JAX, which otherwise does this only when lowering a program."""
    prepare_lapack_call("getrf", np.dtype(float))


def caller_of(greeting: tuple[str, int, int]) -> Callable[[Any], list[np.ndarray]]:
    """The program in a file, from the file and its numbers of input and output arrays."""
    file, n_arguments, n_results = greeting
    taken = jax.tree.structure((tuple(range(n_arguments)), {}))
    program = program_of_file(Path(file), taken, jax.tree.structure(list(range(n_results))))
    return lambda arguments: [np.asarray(each) for each in jax.device_get(program(*arguments))]


def answer_questions(
    questions: BinaryIO, answers: BinaryIO, worker: Callable[[Any], Callable[[Any], Any]]
) -> None:
    """Answer each pickled question with its time in seconds and result, by the `worker` of the greeting."""

    def send(result: Any) -> None:
        pickle.dump(result, answers, pickle.HIGHEST_PROTOCOL)
        answers.flush()

    answer = worker(pickle.load(questions))
    send("ready")
    while True:
        try:
            question = pickle.load(questions)
        except EOFError:
            return
        began = perf_counter()
        found = answer(question)
        send((perf_counter() - began, found))


def serve(worker: Callable[[Any], Callable[[Any], Any]]) -> None:
    """Answer the questions of the parent process on the standard streams, until its input ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # meant for the parent process, which closes the input
    with os.fdopen(os.dup(sys.stdout.fileno()), "wb") as own:
        os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # output of libraries goes to stderr
        answer_questions(sys.stdin.buffer, own, worker)


if __name__ == "__main__":
    serve(caller_of)
