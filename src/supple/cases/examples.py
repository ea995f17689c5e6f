"""The examples of the package: titles and files."""

from __future__ import annotations

import ast
import json
import re
import shutil
import tomllib
from collections.abc import Mapping
from pathlib import Path

from supple.errors import ArgumentError
from supple.importers.toml import nearest_hint
from supple.storage.file_errors import file_errors

__all__ = ["command_of_example", "example_text", "example_titles", "write_example"]

_PACKAGE = Path(__file__).parents[1]
_RUN = (".toml", ".py", ".ipynb")


def example_titles() -> Mapping[str, str]:
    """Title of each example, by its file name."""
    return {path.name: _title(path) for path in sorted(_folder().iterdir()) if path.suffix in _RUN}


def write_example(name: str, folder: Path) -> tuple[Path, ...]:
    """Write an example and its files into `folder`; return their paths, the example first.

    name : as in `example_titles`, with or without its suffix

    Raises
    ------
    ArgumentError       an unknown name; a file that exists already
    ResultFileError     a folder that cannot be written
    """
    titles = example_titles()
    found = [each for each in titles if name in {each, Path(each).stem}]
    if not found:
        raise ArgumentError(
            f"there is no example {name!r}{nearest_hint(name, titles)}; `supple example` lists them"
        )
    files = _needed([_folder() / each for each in found])
    targets = tuple(folder / path.name for path in files)
    for target in targets:
        if target.exists():
            raise ArgumentError(f"{target} exists already: give another folder (-o)")
    with file_errors("write the example into", folder):
        folder.mkdir(parents=True, exist_ok=True)
        for path, target in zip(files, targets, strict=True):
            shutil.copyfile(path, target)
    return targets


def command_of_example(path: Path) -> str:
    """The command that runs an example: a program, a notebook, a table of cases or a case."""
    if path.suffix == ".py":
        return f"python {path}"
    if path.suffix == ".ipynb":
        return f"jupyter lab {path}"
    of_cases = "case" in tomllib.loads(path.read_text("utf-8"))
    return f"supple {'sweep' if of_cases else 'run'} {path}"


def _folder() -> Path:
    """The folder of the examples: in the installed package, or beside `src` in a checkout."""
    installed = _PACKAGE / "examples"
    return installed if installed.is_dir() else _PACKAGE.parents[1] / "examples"


def example_text(path: Path) -> str:
    """The description in a program, a notebook or a case, as plain text."""
    text = path.read_text("utf-8")
    if path.suffix == ".py":
        return ast.get_docstring(ast.parse(text)) or ""
    if path.suffix == ".ipynb":
        return "".join(json.loads(text)["cells"][0]["source"]).lstrip("# ")
    return "\n".join(line.removeprefix("#").removeprefix(" ") for line in text.split("\n\n")[0].splitlines())


def _title(path: Path) -> str:
    """The first sentence of the description of an example."""
    paragraph = " ".join(example_text(path).split("\n\n")[0].split())
    return re.split(r"(?<=[.?!])\s", paragraph)[0]


def _needed(files: list[Path]) -> list[Path]:
    """The files, all files named in their texts (recursively), and notes on the origin of meshes."""
    known = {path.name: path for path in _folder().iterdir() if path.is_file()}
    needed = list(files)
    for path in needed:  # grows during the loop
        text = path.read_text("utf-8") if path.suffix in _RUN else ""
        named = [other for name, other in known.items() if re.search(rf"(?<![\w-]){re.escape(name)}\b", text)]
        origin = known.get(f"{path.stem}.README.md")
        needed += [each for each in [*named, *([origin] if origin else [])] if each not in needed]
    return needed
