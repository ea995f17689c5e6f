"""`supple benchmark`: the benchmarks of installed packages, each loaded on first use.

A package registers a benchmark by an entry point of the group `supple.benchmarks`. Its name is the name of
the command; its object is the function from which Typer creates the command.
"""

from __future__ import annotations

from importlib.metadata import entry_points
from typing import Any, cast

import typer
from typer.core import TyperGroup

__all__ = ["GROUP", "BenchmarkGroup"]

GROUP = "supple.benchmarks"
"""Name of the group of entry points that register benchmarks."""


class BenchmarkGroup(TyperGroup):
    """Group of commands, one per entry point; listing their names loads no benchmark."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings)
        offered = sorted(entry_points(group=GROUP), key=lambda each: each.name)
        self.commands = cast(Any, {each.name: each for each in offered})

    def list_commands(self, ctx: Any) -> list[str]:  # noqa: ARG002  (Typer's signature)
        """Names of all benchmarks, in alphabetical order."""
        return list(self.commands)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:  # noqa: ARG002  (Typer's signature)
        """The command of a benchmark, after its module is loaded; None for an unknown name."""
        offered = cast(Any, self.commands.get(cmd_name))
        if offered is None:
            return None
        single = typer.Typer(add_completion=False, rich_markup_mode=None)
        single.command(cmd_name)(offered.load())
        return typer.main.get_command(single)
