"""Laws of time, one kind per module."""
