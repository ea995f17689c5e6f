"""Base class of the explicit methods of a run."""

from __future__ import annotations

__all__ = ["ExplicitRule"]


class ExplicitRule:
    """Base of `supple.methods.explicit.Explicit`, the method of modal parts and nonlinear finite elements."""
