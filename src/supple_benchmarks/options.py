"""Options of the commands of all benchmarks."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

__all__ = ["Debug", "Json"]

Debug = Annotated[bool, typer.Option("--debug", help="Show the whole traceback of an error.")]
Json = Annotated[Path | None, typer.Option("--json", help="Report file; default: in the output folder.")]
