"""Ties of nodes to another part: matching points, and continuity."""
