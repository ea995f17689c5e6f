"""The reduced bodies of a run, stored beside its motion, whose coordinates refer to their columns."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from pathlib import Path

from supple.machine import System
from supple.reduction import ReducedBody
from supple.storage import file_name, read_reduced_body, write_reduced_body

__all__ = ["reduced_bodies", "store_bodies", "store_body", "with_stored_bodies"]


def reduced_bodies(system: System, names: Collection[str]) -> list[ReducedBody]:
    """The reduced bodies of a system that are among the given names."""
    return [body for name, body in system.bodies_of(ReducedBody).items() if name in names]


def store_body(body: ReducedBody, folder: Path) -> Path:
    """Write a reduced body to its file in the folder of a run; returns the path."""
    return write_reduced_body(stored_path(folder, body.name), body)


def store_bodies(system: System, names: Collection[str], folder: Path) -> None:
    """Write the reduced bodies of a system that are among the given names."""
    for body in reduced_bodies(system, names):
        store_body(body, folder)


def with_stored_bodies(system: System, names: Collection[str], folder: Path) -> System:
    """The system with the stored bodies of a run, to resume this run; bodies not yet stored are written.

    The stored bodies are needed because a repeated reduction may change the signs of columns.
    """
    kept = {
        body.name: read_reduced_body(path)
        for body in reduced_bodies(system, names)
        if (path := stored_path(folder, body.name)).exists()
    }
    store_bodies(system, set(names) - kept.keys(), folder)

    bodies = (
        replace(placed, body=kept[placed.body.name]) if placed.body.name in kept else placed
        for placed in system.bodies
    )
    return replace(system, bodies=tuple(bodies))


def stored_path(folder: Path, name: str) -> Path:
    """The file of a reduced body in the folder of a run."""
    return folder / f"{file_name(name)}-reduced.h5"
