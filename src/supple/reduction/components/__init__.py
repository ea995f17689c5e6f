"""Substructures of the bases, with clamped or free interfaces."""
