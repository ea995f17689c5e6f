"""Floating frame of four points: its pose and rates, and the map of its forces to the points.

With P = [x_A - x_O, x_B - x_O, x_C - x_O], the arm length l, and X_O the position of O in the body's axes,

    A = P / l,    R = x_O - A X_O,    W = P^T P' / l^2,    omega = ax (W - W^T) / 2

R is linear in the points. A force F at R and a moment m (in the axes of the body) become the forces (4, 3)

    f = w_R F^T + E (P skew(m))^T / (2 l^2)

on the points, with the weights w_R of R and E = `CORNERS`. A rigid motion of the points is a rigid motion of
the frame, to round-off, so a balanced pair of forces on frames is also balanced on points.
"""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jax import Array

from supple.algebra.rotation import skew, unskew
from supple.equations.configuration import Configuration
from supple.integrate import FloatingMotion
from supple.methods.explicit.frame_model import FrameState, Generalized
from supple.methods.explicit.frame_moments import arms
from supple.methods.explicit.frame_points import CORNERS
from supple.methods.explicit.modal_frame import ModalFrame


class FrameChart(NamedTuple):
    """Constants of one frame.

    weights : (4,) of the origin R of the body's axes;   centre : (3,) X_O;   arm : l, m
    turned : (k, k) coordinates of the body per mode of the time integration
    """

    weights: Array
    centre: Array
    arm: Array
    turned: Array


def frame_chart(frame: ModalFrame) -> FrameChart:
    """Chart of a modal or rigid part."""
    points = frame.body.points
    return FrameChart(
        jnp.asarray(points.weights(np.zeros((1, 3)))[0]),
        jnp.asarray(points.origin),
        jnp.asarray(points.arm),
        jnp.asarray(frame.turned),
    )


def configuration(charts: tuple[FrameChart, ...], states: tuple[FrameState, ...]) -> Configuration:
    """Configuration of all frames, for the equations of joints and forces."""
    pairs = list(zip(charts, states, strict=True))
    return Configuration(
        jnp.stack([own.weights @ at.p for own, at in pairs]),
        jnp.stack([arms(at.p) / own.arm for own, at in pairs]),
        jnp.concatenate([own.turned @ at.y for own, at in pairs]),
    )


def velocity(charts: tuple[FrameChart, ...], states: tuple[FrameState, ...]) -> Array:
    """Velocities (dR, omega, dq) of all frames, (n,)."""
    found = []
    for own, at in zip(charts, states, strict=True):
        spin = unskew(arms(at.p).T @ arms(at.vp) / own.arm**2)
        found += [own.weights @ at.vp, spin, own.turned @ at.vy]
    return jnp.concatenate(found)


def on_points(own: FrameChart, at: FrameState, forces: Array) -> Generalized:
    """Generalised forces (.., 6 + k) on a frame as forces on points, (.., 4, 3), and modes, (.., k)."""
    moments = jnp.vectorize(skew, signature="(i)->(i,i)")(forces[..., 3:6])
    turning = jnp.asarray(CORNERS) @ jnp.swapaxes(arms(at.p) @ moments, -1, -2) / (2 * own.arm**2)
    return Generalized(own.weights[:, None] * forces[..., None, :3] + turning, forces[..., 6:] @ own.turned)


def placed_state(
    frame: ModalFrame,
    position: np.ndarray,
    rotation: np.ndarray,
    coordinates: np.ndarray,
    rates: np.ndarray,
) -> FrameState:
    """State of a frame at a pose and coordinates, with rates (dR, omega, dq), (6 + k,)."""
    points = frame.body.points
    p = points.placed(position, rotation)
    vp = rates[:3] + np.cross(rotation @ rates[3:6], p - position)
    y, vy = (np.linalg.solve(frame.turned, own) for own in (coordinates, rates[6:]))
    return FrameState(jnp.asarray(p), jnp.asarray(y), jnp.asarray(vp), jnp.asarray(vy))


def floating_motion(frame: ModalFrame, rows: tuple[np.ndarray, ...]) -> FloatingMotion:
    """Motion of a frame from points and modes, their rates and accelerations, one row per output time.

    ddA = A (skew(domega) + skew(omega)^2)
    """
    (p, y, vp, vy, ap, ay), points = rows, frame.body.points
    P, dP, ddP = ((each[:, 1:] - each[:, :1]).swapaxes(1, 2) / points.arm for each in (p, vp, ap))

    def turning(by: np.ndarray) -> np.ndarray:
        W = np.swapaxes(P, 1, 2) @ by
        return 0.5 * np.stack(
            [W[:, 2, 1] - W[:, 1, 2], W[:, 0, 2] - W[:, 2, 0], W[:, 1, 0] - W[:, 0, 1]], axis=1
        )

    weights = points.weights(np.zeros((1, 3)))[0]
    position, speed, change = (np.einsum("a,tai->ti", weights, each) for each in (p, vp, ap))
    q, dq, ddq = (each @ frame.turned.T for each in (y, vy, ay))
    return FloatingMotion(position, P, q, speed, turning(dP), dq, change, turning(ddP), ddq)
