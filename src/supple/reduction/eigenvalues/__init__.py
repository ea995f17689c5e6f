"""Errors of the eigenvalues of a reduced body relative to the full body."""
