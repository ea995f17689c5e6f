"""Whole decks of other programs, read and set beside what these programs say of them."""
