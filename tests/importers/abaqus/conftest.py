"""Decks from text."""

from __future__ import annotations

import pytest

from supple.importers.abaqus.abaqus_deck import read_abaqus_deck


@pytest.fixture
def deck(tmp_path):
    def read(text):
        path = tmp_path / "deck.inp"
        path.write_text(text)
        return read_abaqus_deck(path)

    return read
