"""List or write the examples of the package."""

from __future__ import annotations

from pathlib import Path

from supple import cases
from supple.terminal import print_rows, say


def list_examples() -> None:
    """Print the title of each example."""
    print_rows("Examples: supple example NAME", cases.example_titles().items())


def write_example(name: str, folder: Path) -> None:
    """Write an example into `folder`, and print the command that runs it."""
    files = cases.write_example(name, folder)
    for path in files:
        say(f"wrote {path}")
    first = files[0]
    say(f"Run it: {cases.command_of_example(first)}")
