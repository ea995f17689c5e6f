"""Text files: characters and lines, independent of encoding and line ends."""

from __future__ import annotations

import codecs
from importlib.resources.abc import Traversable
from pathlib import Path

from supple.errors import ImportFormatError

# The longer mark first: that of UTF-32 begins with that of UTF-16.
_MARKS = (
    (codecs.BOM_UTF8, "utf-8"),
    (codecs.BOM_UTF32_LE, "utf-32-le"),
    (codecs.BOM_UTF32_BE, "utf-32-be"),
    (codecs.BOM_UTF16_LE, "utf-16-le"),
    (codecs.BOM_UTF16_BE, "utf-16-be"),
)


def file_content(path: Path | Traversable) -> bytes:
    """All bytes of a file; ImportFormatError if it is missing or unreadable."""
    if not is_file(path):
        raise ImportFormatError(f"{path}: no such file; check its name and folder")
    try:
        return path.read_bytes()
    except OSError as error:
        raise ImportFormatError(
            f"{path}: cannot be read ({error.strerror}); check its permissions"
        ) from error


def unreadable(path: Path, form: str, error: Exception) -> ImportFormatError:
    """The error for a file whose reader fails with another error."""
    return ImportFormatError(
        f"{path}: not readable as {form} ({type(error).__name__}: {error}); is it cut short? Write it again"
    )


def is_file(path: Path | Traversable) -> bool:
    """Whether a file exists; also False for an impossible name."""
    try:
        return path.is_file()
    except (OSError, ValueError):  # a name that is too long, a folder without permission
        return False


def file_text(path: Path | Traversable, remedy: str = "export it as text") -> str:
    """The characters of a text file: in the encoding of its byte-order mark, else in UTF-8, else in Latin-1.

    Numbers and keywords are the same in the last two; accented names may use either.
    ImportFormatError for a file that is missing, unreadable or binary; `remedy` is for a binary file.
    """
    content = file_content(path)
    for mark, encoding in _MARKS:
        if content.startswith(mark):
            try:
                return content[len(mark) :].decode(encoding)
            except UnicodeDecodeError as error:
                raise ImportFormatError(
                    f"{path}: its byte-order mark is that of {encoding.upper()}, but its bytes are not "
                    f"({error.reason}); save it as UTF-8"
                ) from error
    if b"\0" in content:
        raise ImportFormatError(f"{path}: a binary file; {remedy}")
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError:
        return content.decode("latin-1")


def file_lines(path: Path | Traversable, remedy: str = "export it as text") -> list[str]:
    """The lines of a text file, as `file_text` reads it; only CR, LF and CR LF end a line."""
    # str.splitlines ends lines at form feeds and at characters of Latin-1 as well.
    lines = file_text(path, remedy).replace("\r\n", "\n").replace("\r", "\n").split("\n")
    return lines[:-1] if not lines[-1] else lines
