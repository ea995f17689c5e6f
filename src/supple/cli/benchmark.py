"""`supple benchmark`: the benchmarks of installed packages, each loaded on first use.

A package registers a benchmark by an entry point of the group `supple.benchmarks`. Its name is the name of
the command; its object is the function from which Typer creates the command. A name that several packages
register is refused when it is called.
"""

from __future__ import annotations

import gc
from importlib.metadata import EntryPoint, entry_points
from typing import Any, cast

import typer
from typer.core import TyperGroup

from supple.errors import ArgumentError
from supple.terminal import reported_errors

GROUP = "supple.benchmarks"
"""Name of the group of entry points that register benchmarks."""


class BenchmarkGroup(TyperGroup):
    """Group of commands, one per entry point; listing their names loads no benchmark."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings)
        offered: dict[str, dict[str, EntryPoint]] = {}
        for each in sorted(entry_points(group=GROUP), key=lambda each: each.name):
            offered.setdefault(each.name, {})[each.value] = each
        self.commands = cast(Any, offered)

    def list_commands(self, ctx: Any) -> list[str]:  # noqa: ARG002  (Typer's signature)
        """Names of all benchmarks, in alphabetical order."""
        return list(self.commands)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:  # noqa: ARG002  (Typer's signature)
        """The command of a benchmark, after its module is loaded; None for an unknown name."""
        offered = cast("dict[str, EntryPoint] | None", self.commands.get(cmd_name))
        if offered is None:
            return None
        benchmark, *others = offered.values()
        if others:
            with reported_errors(debug=False):
                raise ArgumentError(
                    f"several packages have a benchmark '{cmd_name}': {' and '.join(offered)}; uninstall all "
                    "of them but one"
                )
        gc.enable()  # `reported` enables it for the other commands
        single = typer.Typer(add_completion=False, rich_markup_mode=None)
        single.command(cmd_name)(benchmark.load())
        return typer.main.get_command(single)
