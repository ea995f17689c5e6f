"""Inputs of the motion of a case: its checked tables, and its files with all that they include."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from supple.errors import CaseError
from supple.importers import files_read_with
from supple.importers.toml import CheckedTable
from supple.storage.run_inputs import FILE, Inputs, digest_of

_NOT_COMPUTED_WITH = {"title", "units", "output"}


def inputs_of_case(tables: CheckedTable, files: Iterable[str], folder: Path) -> Inputs:
    """Values of all keys that the motion depends on, defaults included, and digests of all files, by name.

    Raises
    ------
    CaseError   a file that cannot be read
    """
    values = tables.model_dump(exclude=_NOT_COMPUTED_WITH)
    return dict(_leaves("", values)) | digests_of_files(files, folder)


def _leaves(name: str, value: object) -> Iterator[tuple[str, str]]:
    """Path and text of every value below a key; the path of a table in a list contains its name or number."""
    if isinstance(value, Mapping):
        for key, item in value.items():
            yield from _leaves(f"{name}.{key}" if name else key, item)
    elif isinstance(value, list | tuple) and value and all(isinstance(item, Mapping) for item in value):
        labels = [str(item.get("name") or number) for number, item in enumerate(value, start=1)]
        yield f"order of {name}", ", ".join(labels)
        for label, item in zip(labels, value, strict=True):
            yield from _leaves(f"{name} '{label}'", item)
    elif value is not None:
        yield name, repr(value)


def digests_of_files(files: Iterable[str], folder: Path) -> dict[str, str]:
    """Digests of files and of all that they include, by name; CaseError where one cannot be read."""
    found = {}
    for name in files:
        for path in files_read_with(folder / name):
            try:
                found[f"{FILE}{_shown(path, folder)}"] = digest_of(path.read_bytes())
            except OSError as error:
                raise CaseError(f"cannot read {path}: {error.strerror}; check the path") from error
    return found


def missing_files(files: Iterable[str], folder: Path) -> dict[str, str]:
    """The word "missing" for each file that does not exist, by name."""
    paths = [folder / name for name in files]
    return {f"{FILE}{_shown(path, folder)}": "missing" for path in paths if not path.exists()}


def _shown(path: Path, folder: Path) -> str:
    """Path relative to the case file: the same text for any working directory."""
    return path.relative_to(folder).as_posix() if path.is_relative_to(folder) else path.as_posix()
