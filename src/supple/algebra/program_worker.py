"""A process that runs one kept program for another process (`worker_processes`).

It is a script of its own, which needs JAX and nothing of supple: it is ready in the time that JAX takes to be
imported. By its input it is told the file of the program, the numbers of arrays that go in and come out, and
then arguments; by its output it answers with seconds and results. It ends with its input.
"""

from __future__ import annotations

import io
import os
import pickle
import signal
import sys
import zlib
from pathlib import Path
from time import perf_counter
from typing import Any, BinaryIO

import jax
import numpy as np
from jax.experimental import serialize_executable


def answer(questions: BinaryIO, answers: BinaryIO) -> None:
    """Run the program for all that is asked."""
    file, n_arguments, n_results = pickle.load(questions)
    # As `kept_programs` has it: JAX finds the routines of LAPACK as it writes a program that calls one.
    jax.jit(jax.lax.linalg.lu).lower(jax.ShapeDtypeStruct((1, 1), float))
    content = pickle.load(io.BytesIO(zlib.decompress(Path(file).read_bytes())))
    taken = jax.tree.structure((tuple(range(n_arguments)), {}))
    given = jax.tree.structure(list(range(n_results)))
    program = serialize_executable.deserialize_and_load(
        content, taken, given, execution_devices=jax.devices()[:1]
    )
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
