"""Matrices and labels of interface motions, and the interfaces that a frame fixes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from supple.body import BodyInterface, FlexibleBody, Frame
from supple.body.checks import FREEDOM_NAMES
from supple.errors import ModelError


def fixed_interfaces(body: FlexibleBody, frame: Frame) -> tuple[BodyInterface, ...]:
    """Interfaces whose six motions are zero in the frame: rows of B that are in the row space of D."""
    rows, _ = np.linalg.qr(frame.constraint(body).T)

    def lies_in(motion: np.ndarray) -> bool:
        outside = motion.T - rows @ (rows.T @ motion.T)
        return bool(np.linalg.norm(outside) <= 1e-10 * np.linalg.norm(motion))

    return tuple(each for each in body.interfaces if lies_in(motion_rows([each])))


def motion_rows(interfaces: Sequence[BodyInterface]) -> np.ndarray:
    """B (6 p, n), dense: the motions of p interfaces are q_v = B q."""
    return np.vstack([interface.motion.toarray() for interface in interfaces])


def column_labels(kind: str, interfaces: Sequence[BodyInterface]) -> tuple[str, ...]:
    """One label for each motion of each interface, such as 'attachment tip uy'."""
    return tuple(f"{kind} {interface.name} {motion}" for interface in interfaces for motion in FREEDOM_NAMES)


def require_interfaces(body: FlexibleBody, method: str) -> None:
    """Raise ModelError if the body has no interface; `method` is the name of what needs one."""
    if not body.interfaces:
        raise ModelError(
            f"{method} needs interfaces, but body '{body.name}' has none; "
            "define one on a node set, or use NormalModes"
        )
