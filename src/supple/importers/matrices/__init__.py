"""Readers of mass, stiffness, damping and recovery matrices of other programs."""
