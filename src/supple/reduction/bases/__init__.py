"""Bases of linear columns, one per module."""
