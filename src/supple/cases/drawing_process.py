"""A separate process that draws a run while its error is estimated.

It receives the drawing in a file, and reports its progress. It is started for long runs, on computers with a
spare core. If it cannot be started, or ends early, the drawing is done in this process.
"""

from __future__ import annotations

import copyreg
import pickle
import subprocess
import sys
import tempfile
from collections.abc import Callable
from contextlib import suppress
from time import perf_counter
from types import MappingProxyType
from typing import Any

from supple.blas_threads import one_blas_thread
from supple.cases.drawing import Drawing
from supple.integrate import StepProgress
from supple.other_processes import available_cores, python_command, python_environment

WORTH = 20.0
"""Least wall time of a run, s, for a separate process; the error estimate of a shorter run is too short."""


class DrawingProcess:
    """Draws a run once, in this process or in a separate one, which ends with the `with` block."""

    def __init__(self) -> None:
        self._began = perf_counter()
        self._process: subprocess.Popen[str] | None = None

    def __enter__(self) -> DrawingProcess:
        return self

    def __exit__(self, *_: object) -> None:
        self._drop()

    def begin(self, drawing: Callable[[], Drawing | None]) -> None:
        """Start drawing in a separate process if the run took `WORTH` and a second core is available.

        An earlier drawing is cancelled in any case.

        drawing : function that returns the drawing, or None for no drawing; not called after a shorter run
        """
        self._drop()
        if perf_counter() - self._began < WORTH or available_cores() < 2:
            return
        asked = drawing()
        # User functions and matrix factors cannot be pickled, and a disk may be full: then `finish` draws.
        with suppress(Exception):
            self._process = None if asked is None else _process(asked)

    def finish(self, drawing: Drawing | None, progress: StepProgress) -> None:
        """Wait for the separate process, or draw here; raises the errors of `Drawing.draw`."""
        if drawing is not None and not self._is_drawn_beside(progress):
            drawing.draw(progress)

    def _is_drawn_beside(self, progress: StepProgress) -> bool:
        """Whether a separate process was started and has finished successfully."""
        process = self._process
        if process is None or process.stdout is None:
            return False
        for line in process.stdout:
            step, share = line.rsplit("\t", 1)
            progress(step, float(share))
        return process.wait() == 0

    def _drop(self) -> None:
        """End the process, if there is one."""
        if self._process is not None:
            self._process.kill()
            self._process.communicate()
            self._process = None


def _process(drawing: Drawing) -> subprocess.Popen[str]:
    with tempfile.TemporaryFile() as sent:
        pickler = pickle.Pickler(sent, pickle.HIGHEST_PROTOCOL)
        pickler.dispatch_table = copyreg.dispatch_table | {MappingProxyType: _as_dict}
        pickler.dump(drawing)
        sent.seek(0)
        return subprocess.Popen(
            python_command("-m", __name__),
            env=python_environment(JAX_PLATFORMS="cpu"),
            stdin=sent,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )


def _as_dict(mapping: MappingProxyType[Any, Any]) -> tuple[Any, ...]:
    """Pickle a read-only mapping as a dict: Python cannot pickle it."""
    return dict, (dict(mapping),)


def _report(step: str, share: float) -> None:
    sys.stdout.write(f"{step}\t{share}\n")
    sys.stdout.flush()


if __name__ == "__main__":
    with one_blas_thread():
        pickle.load(sys.stdin.buffer).draw(_report)
