"""Dependence of a body's response on its frame, ties and basis, compared with independent references."""
