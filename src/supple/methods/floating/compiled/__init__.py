"""The engine for rigid and reduced bodies: compiled, dense."""
