"""Line numbers of the keys of a TOML text, which the standard TOML reader does not provide."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

__all__ = ["KeyPath", "LineIndex", "index_lines"]

KeyPath = tuple[str | int, ...]

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")
_BLANK = re.compile(r"(?:[ \t\r\n]|#[^\n]*)+")
_SPACE = re.compile(r"[ \t]+")
# Longest opening quote first, so that ''' is not read as an empty literal string.
_STRING = re.compile(
    r'"""(?:[^\\]|\\.)*?"{3,5}|\'\'\'.*?\'{3,5}|"(?:[^"\\\n]|\\.)*"|\'[^\'\n]*\'',
    re.DOTALL,
)
_SCALAR = re.compile(r"[^,\]}#\n]+")


@dataclass(frozen=True)
class LineIndex:
    """Line (from 1) of every key, table and array item of a TOML text, by its path from the root."""

    lines: Mapping[KeyPath, int]

    def line_of(self, path: KeyPath) -> int:
        """Line of the key at `path`, or of the nearest table around it when the key is not in the text."""
        for length in range(len(path), 0, -1):
            if path[:length] in self.lines:
                return self.lines[path[:length]]
        return 1


def index_lines(text: str) -> LineIndex:
    """Index the lines of a TOML text that the standard reader accepted; its grammar is not checked again."""
    # A path that occurs twice (in a dotted key, then in a header of its own) has its first line.
    lines: dict[KeyPath, int] = {}
    for path, line in _Scanner(text).document():
        lines.setdefault(path, line)
    return LineIndex(lines)


class _Scanner:
    """One pass over the text; each method consumes one construct of the grammar and yields (path, line)."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._at = 0
        self._line = 1
        self._array_lengths: dict[KeyPath, int] = {}

    def document(self) -> Iterator[tuple[KeyPath, int]]:
        """Every key, table and item of an array, with its line."""
        table: KeyPath = ()
        self._skip(_BLANK)
        while self._at < len(self._text):
            line = self._line
            if self._accept("[["):
                table = self._open_array_table(self._key())
                self._expect("]]")
                yield from ((table[:end], line) for end in range(1, len(table) + 1))
            elif self._accept("["):
                table = self._inside_arrays(self._key())
                self._expect("]")
                yield from ((table[:end], line) for end in range(1, len(table) + 1))
            else:
                yield from self._key_and_value(table)
            self._skip(_BLANK)

    def _key_and_value(self, table: KeyPath) -> Iterator[tuple[KeyPath, int]]:
        line = self._line
        path = table + self._key()
        self._expect("=")
        yield from ((path[:end], line) for end in range(len(table) + 1, len(path) + 1))
        yield from self._value(path)

    def _value(self, path: KeyPath) -> Iterator[tuple[KeyPath, int]]:
        if self._accept("["):
            yield from self._array(path)
        elif self._accept("{"):
            yield from self._inline_table(path)
        elif not self._skip(_STRING):
            self._skip(_SCALAR)

    def _array(self, path: KeyPath) -> Iterator[tuple[KeyPath, int]]:
        position = 0
        self._skip(_BLANK)
        while not self._accept("]"):
            yield (*path, position), self._line
            yield from self._value((*path, position))
            position += 1
            self._skip(_BLANK)
            self._accept(",")
            self._skip(_BLANK)

    def _inline_table(self, path: KeyPath) -> Iterator[tuple[KeyPath, int]]:
        self._skip(_BLANK)
        while not self._accept("}"):
            yield from self._key_and_value(path)
            self._skip(_BLANK)
            self._accept(",")
            self._skip(_BLANK)

    def _key(self) -> KeyPath:
        parts: list[str | int] = [self._key_part()]
        while self._accept("."):
            parts.append(self._key_part())
        return tuple(parts)

    def _key_part(self) -> str:
        self._skip(_SPACE)
        part = self._skip(_STRING)
        # A quoted key may contain escapes; known keys have none, so their lines are found.
        part = part[1:-1] if part else self._skip(_BARE_KEY)
        self._skip(_SPACE)
        return part

    def _open_array_table(self, key: KeyPath) -> KeyPath:
        array = (*self._inside_arrays(key[:-1]), key[-1])
        position = self._array_lengths.get(array, 0)
        self._array_lengths[array] = position + 1
        return (*array, position)

    def _inside_arrays(self, key: KeyPath) -> KeyPath:
        """Path of a header `[a.b]`, with the last item of each array of tables that it passes through."""
        path: KeyPath = ()
        for part in key:
            path = (*path, part)
            if path in self._array_lengths:
                path = (*path, self._array_lengths[path] - 1)
        return path

    def _skip(self, pattern: re.Pattern[str]) -> str:
        found = pattern.match(self._text, self._at)
        if not found:
            return ""
        self._advance(found.group())
        return found.group()

    def _accept(self, token: str) -> bool:
        if not self._text.startswith(token, self._at):
            return False
        self._advance(token)
        self._skip(_SPACE)
        return True

    def _expect(self, token: str) -> None:
        if not self._accept(token):
            raise ValueError(f"line {self._line}: expected {token!r} in a valid TOML text")

    def _advance(self, taken: str) -> None:
        self._at += len(taken)
        self._line += taken.count("\n")
