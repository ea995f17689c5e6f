"""The command `supple benchmark decks`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from supple.terminal import reported_errors, reported_warnings
from supple_benchmarks.options import Debug, Json

__all__ = ["decks"]


def decks(
    folder: Annotated[Path, typer.Argument(help="Folder of decks, with their expected.json.")],
    json: Json = None,
    seconds: Annotated[float, typer.Option(min=1.0, help="Time that one deck may take.")] = 60.0,
    debug: Debug = False,
) -> None:
    """Read every deck of a folder; compare mass, centre and frequencies with its expected.json."""
    from supple_benchmarks.decks.perform import perform

    with reported_errors(debug=debug), reported_warnings():
        perform(folder, json or Path("results/decks.json"), seconds)
