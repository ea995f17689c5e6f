"""Complete decks of other programs, compared with the results of these programs."""
