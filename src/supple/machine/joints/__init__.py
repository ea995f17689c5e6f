"""Joints, one per module."""
