"""Small bodies on which the definitions of reduction are checked."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import linalg

from supple.body import (
    AveragingInterface,
    FlexibleBody,
    MeanAxisFrame,
    NodalFixedFrame,
    RigidInterface,
    flexible_body,
)
from supple.fem import HomogeneousWall, Isotropic, shell_model, solid_model
from supple.mesh import CellType, block, strip

LENGTH = 10.0


def _strip_body(n_length: int, *interfaces: str) -> FlexibleBody:
    """The rotating beam of [Wu2019] as a flat strip: EA = 2.8e7 N, EI = 1.4e4 N m^2, 1.2 kg/m, nu = 0."""
    thickness = 0.006**0.5
    width = 0.4
    material = Isotropic(2.8e7 / (thickness * width), 0.0, 1.2 / (thickness * width))
    model = shell_model(strip(LENGTH, width, n_length, 2), HomogeneousWall(material, thickness))
    return flexible_body("strip", model, tuple(RigidInterface(name, name) for name in interfaces))


def _lowest_squares(body, frame, n_modes):
    """Lowest omega^2 in a frame, from the dense inverse pencil M x = mu K x: its largest mu are precise."""
    Z = linalg.null_space(frame.constraint(body))
    mu = linalg.eigh(Z.T @ (body.mass @ Z), Z.T @ (body.stiffness @ Z), eigvals_only=True)
    return 1.0 / mu[::-1][:n_modes]


@pytest.fixture(scope="session")
def lowest_squares():
    return _lowest_squares


def _nonlinear_static(body, D, load):
    """Newton's method on f(q) + D^T mu = F, D q = 0, dense."""
    n, m = D.shape[1], D.shape[0]
    D = D * body.stiffness.diagonal().max() / np.abs(D).max()
    q, mu = np.zeros(n), np.zeros(m)
    for _ in range(12):
        residual = np.concatenate([body.assembly.internal_force(q) + D.T @ mu - load, D @ q])
        tangent = np.block([[body.assembly.tangent(q).toarray(), D.T], [D, np.zeros((m, m))]])
        step = np.linalg.solve(tangent, -residual)
        q, mu = q + step[:n], mu + step[n:]
        if np.abs(step[:n]).max() < 1e-9 * np.abs(q).max():
            return q
    raise AssertionError("Newton's method did not converge")


@pytest.fixture(scope="session")
def nonlinear_static():
    return _nonlinear_static


@pytest.fixture(scope="session")
def cantilever():
    return _strip_body(8, "root")


@pytest.fixture(scope="session")
def strip_body():
    return _strip_body(8, "root", "tip")


@pytest.fixture(scope="session")
def solid_body():
    model = solid_model(block(2.0, 0.5, 0.3, 4, 2, 1, CellType.TETRA4), Isotropic(1e7, 0.3, 1000.0))
    return flexible_body("block", model, (RigidInterface("root", "root"), RigidInterface("tip", "tip")))


@pytest.fixture(scope="session")
def root_frame():
    return NodalFixedFrame("root")


@pytest.fixture(scope="session")
def mean_axis():
    return MeanAxisFrame()


@pytest.fixture(params=["nodal-fixed", "mean-axis"])
def frame(request):
    return {"nodal-fixed": NodalFixedFrame("root"), "mean-axis": MeanAxisFrame()}[request.param]


@pytest.fixture(scope="session")
def averaging_body():
    """A solid whose tip is an averaging interface: nothing is eliminated there."""
    model = solid_model(block(2.0, 0.5, 0.3, 4, 2, 1, CellType.TETRA4), Isotropic(1e7, 0.3, 1000.0))
    interfaces = (RigidInterface("root", "root"), AveragingInterface("tip", "tip"))
    return flexible_body("block", model, interfaces)


@pytest.fixture(scope="session")
def loose_body():
    """A body without interfaces."""
    return _strip_body(2)
