"""Linear reduction bases, one per module."""
