"""Loads on the nodes of a body, one kind per module."""
