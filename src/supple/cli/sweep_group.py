"""The group of commands `supple sweep`, available before the solvers are loaded."""

from __future__ import annotations

from typing import Any

from typer.core import TyperGroup

__all__ = ["SweepGroup"]


class SweepGroup(TyperGroup):
    """The commands of `sweep`; a file name in place of a command runs that sweep."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """The arguments, with `run` inserted before a file name or an option of that command."""
        if args and args[0] not in {*self.commands, "--help"}:
            args = ["run", *args]
        return super().parse_args(ctx, args)
