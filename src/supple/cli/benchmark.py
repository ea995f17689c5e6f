"""`supple benchmark`: the benchmarks that installed packages offer, each loaded on first use.

A package offers one by an entry point of the group `supple.benchmarks`: the command's name, and the function
that Typer makes the command of.
"""

from __future__ import annotations

from importlib.metadata import entry_points
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
        offered = sorted(entry_points(group=GROUP), key=lambda each: each.name)
        self.commands = cast(Any, {each.name: each for each in offered})

    def list_commands(self, ctx: Any) -> list[str]:  # noqa: ARG002  (Typer's signature)
        """Names of all benchmarks, in order."""
        return list(self.commands)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:  # noqa: ARG002  (Typer's signature)
        """The command of a benchmark, which is loaded now; None of a name that nobody offers."""
        offered = cast(Any, self.commands.get(cmd_name))
        if offered is None:
            return None
        single = typer.Typer(add_completion=False, rich_markup_mode=None)
        single.command(cmd_name)(offered.load())
        return typer.main.get_command(single)
