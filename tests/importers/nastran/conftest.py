"""Decks of a few lines, read."""

from __future__ import annotations

import pytest

from supple.importers.nastran.deck_file import read_nastran_deck


@pytest.fixture
def deck(tmp_path):
    """Reads the text of a deck, without case control or with it."""

    def read(text):
        path = tmp_path / "deck.bdf"
        path.write_text(text)
        return read_nastran_deck(path)

    return read
