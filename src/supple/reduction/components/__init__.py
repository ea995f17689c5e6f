"""Substructures as the bases see them: clamped or free at their interfaces."""
