"""Floating frames (compiled and full), intrinsic lines, and explicit parts. No method imports another."""
