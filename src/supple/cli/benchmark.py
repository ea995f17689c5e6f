"""`supple benchmark`: the benchmarks that installed packages offer, each loaded when it is asked for.

A package offers one by an entry point of the group `supple.benchmarks`: the command's name, and the function
that Typer makes the command of.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from importlib.metadata import EntryPoint, entry_points
from typing import Any, cast

import typer
from typer.core import TyperGroup

__all__ = ["GROUP", "BenchmarkGroup"]

GROUP = "supple.benchmarks"
"""Entry points by which benchmarks are found."""


class BenchmarkGroup(TyperGroup):
    """Group of commands, one for each entry point; their names are known before any of them is loaded."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings)
        self.commands = cast(Any, _OfferedCommands())

    def list_commands(self, ctx: Any) -> list[str]:  # noqa: ARG002  (Typer's signature)
        """Names of all benchmarks, in order."""
        return list(self.commands)


class _OfferedCommands(Mapping[str, Any]):
    """The commands by name; to look one up loads it."""

    def __init__(self) -> None:
        found = sorted(entry_points(group=GROUP), key=lambda each: each.name)
        self._entry_points: dict[str, EntryPoint] = {each.name: each for each in found}

    def __getitem__(self, name: str) -> Any:
        single = typer.Typer(add_completion=False)
        single.command(name)(self._entry_points[name].load())
        return typer.main.get_command(single)

    def __iter__(self) -> Iterator[str]:
        return iter(self._entry_points)

    def __len__(self) -> int:
        return len(self._entry_points)
