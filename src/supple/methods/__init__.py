"""Floating frames, compiled and full; intrinsic lines; explicit parts. None imports another."""
