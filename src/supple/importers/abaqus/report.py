"""Report: the treatment of each keyword, collected while reading."""

from __future__ import annotations

from collections import Counter

from supple.arrays import IntArray
from supple.errors import ImportFormatError
from supple.importers.abaqus.element_types import ElementBlock
from supple.importers.deck import LeftOut
from supple.importers.keyword_file import KeywordBlock, KeywordFile


class Report:
    """Counts of keywords read and ignored, omissions, notes and doubts.

    Doubts are mistakes that do not prevent reading, such as a set of unknown nodes; if `strict`, they raise
    ImportFormatError.
    """

    def __init__(self, file: KeywordFile, *, strict: bool = False) -> None:
        self.file = file
        self._strict = strict
        self.read: Counter[str] = Counter()
        self.passed_over: Counter[str] = Counter()
        self._doubts: list[ImportFormatError] = []
        self._left_out: dict[tuple[str, str], list[int]] = {}
        self._notes: dict[str, None] = {}

    def leave_out(self, card: str, line: int, meaning: str, count: int = 1) -> None:
        """Record data that would change the body but are not read; `line` is an index of `file.lines`."""
        entry = self._left_out.setdefault((card, meaning), [0, self.file.lines[line][1]])
        entry[0] += count

    def leave_out_block(self, block: KeywordBlock, meaning: str) -> None:
        """Record a keyword that is not read."""
        self.leave_out(f"*{block.name}", block.line, meaning)

    def leave_out_elements(self, block: ElementBlock, places: IntArray, meaning: str) -> None:
        """Record elements of a block, by their indices, that are not read."""
        first = int(block.lines[places[0]])
        self.leave_out(f"*ELEMENT, TYPE={block.type.name}", first, meaning, len(places))

    def note(self, text: str) -> None:
        """Record a note of one sentence, once."""
        self._notes[text] = None

    def doubt(self, line: int, message: str) -> None:
        """Record a mistake that does not prevent reading; ImportFormatError if strict."""
        error = self.file.error(line, message)
        if self._strict:
            raise error
        self._doubts.append(error)

    @property
    def left_out(self) -> tuple[LeftOut, ...]:
        """All omissions in order."""
        return tuple(
            LeftOut(card, count, line, meaning) for (card, meaning), (count, line) in self._left_out.items()
        )

    @property
    def notes(self) -> tuple[str, ...]:
        """All notes, the first five doubts, and the number of further doubts."""
        doubts = [str(error) for error in self._doubts]
        more = [f"{len(doubts) - 5} more of that kind"] if len(doubts) > 5 else []
        return (*self._notes, *doubts[:5], *more)
