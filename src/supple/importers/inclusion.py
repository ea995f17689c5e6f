"""Included input files; limits of their number and size, far above those of real models."""

from __future__ import annotations

from pathlib import Path

from supple.errors import ImportFormatError
from supple.importers.text_file import file_lines, is_file

DEEPEST_INCLUSION = 20  # levels; deeper nesting is an error, as for a file that includes itself
MOST_INCLUSIONS = 1000
"""Largest number of inclusions in one model; more are an error.

Twenty files that each include the next file three times make over 10^9 inclusions.
"""
MOST_INCLUDED_CHARACTERS = 2**30
"""Largest number of characters in all inclusions of one model; more are an error."""


def included_file(name: str, *folders: Path) -> Path:
    """The file with this name in the first folder that has it; if none has, upper and lower case are ignored.

    Backslashes also separate folders. A prefix `PLACE:` of more than one letter, the logical name of a folder
    on the author's computer, is dropped. If no folder has the file, its path in the first folder is returned.
    """
    words = name.replace("\\", "/")
    place, colon, rest = words.partition(":")
    if colon and len(place) > 1 and "/" not in place:
        words = rest
    for folder in folders:
        if is_file(folder / words):
            return folder / words
    for folder in folders:
        found = _any_case(folder, words)
        if found is not None:
            return found
    return folders[0] / words


def _any_case(folder: Path, words: str) -> Path | None:
    """The file at this path; parts without an exact match may differ in case. None if none or several do."""
    at = folder
    for part in Path(words).parts:
        if part in ("..", ".") or (at / part).exists():
            at = at / part
            continue
        try:
            alike = [entry for entry in at.iterdir() if entry.name.lower() == part.lower()]
        except OSError:
            return None
        if len(alike) != 1:
            return None
        at = alike[0]
    return at if is_file(at) else None


class Inclusions:
    """Reader of a file and the files it includes; limits their number and size."""

    def __init__(self, remedy: str) -> None:
        self._remedy = remedy
        self._number = 0
        self._characters = 0

    def lines(self, path: Path) -> list[str]:
        """Lines of the main file."""
        return file_lines(path, self._remedy)

    def included(self, path: Path, number: int, target: Path, depth: int) -> list[str]:
        """Lines of `target`, which line `number` of the file `path` includes.

        depth : nesting level of `target`; 1 if the main file includes it

        Raises
        ------
        ImportFormatError   no such file, or no text file; too deep, too many or too large inclusions
        """

        def error(message: str) -> ImportFormatError:
            return ImportFormatError(f"{path}, line {number}: {message}")

        if depth > DEEPEST_INCLUSION:
            raise error(f"includes nest over {DEEPEST_INCLUSION} deep; does a file include itself?")
        if not is_file(target):
            raise error(f"includes {target}, and there is no such file; check its name and folder")
        self._number += 1
        if self._number > MOST_INCLUSIONS:
            raise error(
                f"more than {MOST_INCLUSIONS} inclusions in one model; do files include one another over and "
                "over? Write the model into fewer files"
            )
        lines = file_lines(target, self._remedy)
        self._characters += sum(map(len, lines))
        if self._characters > MOST_INCLUDED_CHARACTERS:
            raise error(
                f"the included files hold more than {MOST_INCLUDED_CHARACTERS} characters; is one included "
                "over and over? Write the model into one file"
            )
        return lines
