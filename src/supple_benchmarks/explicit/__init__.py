"""Explicit combined modal reduction: its promises, measured."""
