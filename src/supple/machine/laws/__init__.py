"""Laws of time, one kind per module."""

from supple.machine.laws.time_law import (
    Constant,
    Table,
    TimeFunction,
    TimeLaw,
    Turning,
)

__all__ = [
    "Constant",
    "Table",
    "TimeFunction",
    "TimeLaw",
    "Turning",
]
