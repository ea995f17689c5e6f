"""The compiled march: runs of one machine that differ in numbers alone share a program, however long."""

from __future__ import annotations

from supple.algebra.kept_programs import KeptProgram
from supple.multibody.compiled.time_step import march
from supple.multibody.equations.compiler_options import MARCHING

__all__ = ["COMPILED_MARCH", "STOPS_AT_ONCE"]

COMPILED_MARCH = KeptProgram(march, MARCHING)
STOPS_AT_ONCE = 128
"""Output times of a call: fewer repeat the last one, which costs nothing; more take several calls."""
