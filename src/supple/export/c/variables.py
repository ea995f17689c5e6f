"""Inputs and outputs of an exported machine by name."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Variable"]


@dataclass(frozen=True)
class Variable:
    """One number that a machine takes or gives.

    start : at the start of the run
    """

    name: str
    unit: str
    description: str
    start: float = 0.0
