"""The examples that come with the package, listed or written."""

from __future__ import annotations

from pathlib import Path

from supple import cases
from supple.terminal import print_rows, say


def list_examples() -> None:
    """Print what each example is about."""
    print_rows("Examples: supple example NAME", cases.example_titles().items())


def write_example(name: str, folder: Path) -> None:
    """Write an example into `folder`, and print how it is run."""
    files = cases.write_example(name, folder)
    for path in files:
        say(f"wrote {path}")
    first = files[0]
    say(f"Run it: {cases.command_of_example(first)}")
