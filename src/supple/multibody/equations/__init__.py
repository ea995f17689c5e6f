"""Equations of motion of a system of floating bodies."""
