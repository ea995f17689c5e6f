"""What explicit marches of parts are to a run."""

from __future__ import annotations

__all__ = ["ExplicitRule"]


class ExplicitRule:
    """Base of `supple.explicit.Explicit`, the step rule of modal parts and of nonlinear finite elements."""
