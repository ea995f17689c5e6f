"""The reduced bodies of a run, kept beside its motion: the coordinates mean nothing without them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from supple.cli.build_system import BuiltCase
from supple.machine import Placed
from supple.reduction import ReducedBody
from supple.storage import read_reduced_body, write_reduced_body


def kept_path(folder: Path, name: str) -> Path:
    """Where the reduction of a body is kept."""
    return folder / f"{name}-reduced.h5"


def with_kept_bodies(built: BuiltCase, folder: Path, *, resume: bool) -> BuiltCase:
    """Keep the bodies that a case has reduced; to resume, take those that the run began with.

    Reduced again, their columns may have other signs.
    """
    made_here = {table.name for table in built.case_file.case.body if table.reduced is None}

    def kept(placed: Placed) -> Placed:
        if not isinstance(placed.body, ReducedBody) or placed.body.name not in made_here:
            return placed
        path = kept_path(folder, placed.body.name)
        if resume and path.exists():
            return replace(placed, body=read_reduced_body(path))
        write_reduced_body(path, placed.body)
        return placed

    bodies = tuple(kept(placed) for placed in built.system.bodies)
    return replace(built, system=replace(built.system, bodies=bodies))
