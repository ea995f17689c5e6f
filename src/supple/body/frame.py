"""Floating frames: the six conditions that separate a body's rigid motion from its deformation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from supple.arguments import check_fields
from supple.body.flexible_body import FlexibleBody
from supple.errors import ModelError

__all__ = ["Frame", "MeanAxisFrame", "NodalFixedFrame", "frame_projector", "smaller_rotations"]


class Frame(Protocol):
    """A choice of frame: six linear conditions D q = 0 on a body's coordinates."""

    def constraint(self, body: FlexibleBody) -> NDArray[np.float64]:
        """D (6, n); with the rigid modes R (n, 6) of the body, D R must be regular."""
        ...


@dataclass(frozen=True)
class NodalFixedFrame:
    """The frame moves with an interface, so that the interface has q_v = 0 in the frame. [Wu2019 (11)]

    q_v : displacement and rotation of the interface (6,)
    """

    interface: str

    def __post_init__(self) -> None:
        check_fields(self)

    def constraint(self, body: FlexibleBody) -> NDArray[np.float64]:
        """D (6, n), which is `motion` of the interface; ModelError if the body has no such interface."""
        return body.interface(self.interface).motion.toarray()


@dataclass(frozen=True)
class MeanAxisFrame:
    """The frame follows the body's mean motion: to first order, deformation has no momentum in the frame.

    This is the linearised Tisserand frame, R^T M q = 0. [Wu2019 (17)-(18)]
    """

    def constraint(self, body: FlexibleBody) -> NDArray[np.float64]:
        """D = R^T M (6, n)."""
        return (body.mass @ body.rigid_modes).T


def smaller_rotations(frame: Frame | None) -> str:
    """Text for messages: the change of model that reduces a body's rotation relative to its frame.

    frame : None for a body whose frame cannot be chosen
    """
    split = (
        "split the body (split = { parts = 2 } in a case file, split_body in Python), or condense a slender "
        "body to stations along its length (condense = { .. }, or condense in Python)"
    )
    return split if isinstance(frame, MeanAxisFrame) else f"choose a mean-axis frame, or {split}"


def frame_projector(body: FlexibleBody, frame: Frame) -> Callable[[NDArray[np.float64]], NDArray[np.float64]]:
    """The map P x = x - R (D R)^-1 D x, from motions (n,) or (n, k) to motions relative to the frame.

    D is the constraint matrix of the frame, and R the rigid modes of the body.
    Raises ModelError if D R is singular; the frame then does not fix the rigid motion.
    """
    D, R = frame.constraint(body), body.rigid_modes
    fixed = D @ R
    if np.linalg.matrix_rank(fixed / np.linalg.norm(fixed, axis=1)[:, None]) < 6:
        raise ModelError(f"{frame} does not fix the rigid motion of body '{body.name}'; choose another frame")
    rigid_part = R @ np.linalg.inv(fixed)
    return lambda x: x - rigid_part @ (D @ x)
