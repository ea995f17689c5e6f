"""Write a commented case file for a mesh."""

from __future__ import annotations

from pathlib import Path

from supple import cases
from supple.terminal import say


def new_case(mesh: Path, path: Path | None) -> None:
    """Write a commented case for the mesh or the machine file, and print the next step."""
    written = path or Path(f"{mesh.stem}.toml")
    cases.write_new_case(mesh, written)
    say(f"wrote {written}: edit the lines marked GUESS, then run: supple run {written}")
