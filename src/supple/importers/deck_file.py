"""Read a deck: the format follows from the suffix of the file."""

from __future__ import annotations

from pathlib import Path

from supple.errors import ImportFormatError
from supple.importers.abaqus.abaqus_deck import read_abaqus_deck
from supple.importers.deck import Deck
from supple.importers.nastran.deck_file import read_nastran_deck
from supple.importers.nastran.mesh_view import NASTRAN_SUFFIXES

__all__ = ["DECK_SUFFIXES", "read_deck"]

READERS = {".inp": read_abaqus_deck} | dict.fromkeys(NASTRAN_SUFFIXES, read_nastran_deck)

DECK_SUFFIXES = tuple(READERS)


def read_deck(path: str | Path) -> Deck:
    """The finite-element model in a file; ImportFormatError lists the supported suffixes."""
    suffix = Path(path).suffix.lower()
    if suffix not in READERS:
        raise ImportFormatError(f"{path}: not a deck file; give one that ends in {', '.join(DECK_SUFFIXES)}")
    return READERS[suffix](path)
