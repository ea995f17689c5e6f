"""Small bodies on which the definitions of reduction are checked."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from scipy import linalg, sparse

from supple.algebra import lowest_modes
from supple.body import (
    AveragingInterface,
    FlexibleBody,
    MeanAxisFrame,
    NodalFixedFrame,
    RigidInterface,
    flexible_body,
)
from supple.fem import HomogeneousSection, Isotropic, shell_model, solid_model
from supple.mesh import CellType, block, strip
from supple.reduction.bases.interface_columns import motion_rows

LENGTH = 10.0


def _strip_body(n_length: int, *interfaces: str) -> FlexibleBody:
    """The rotating beam of [Wu2019] as a flat strip: EA = 2.8e7 N, EI = 1.4e4 N m^2, 1.2 kg/m, nu = 0."""
    thickness = 0.006**0.5
    width = 0.4
    material = Isotropic(2.8e7 / (thickness * width), 0.0, 1.2 / (thickness * width))
    model = shell_model(strip(LENGTH, width, n_length, 2), HomogeneousSection(material, thickness))
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


@dataclass(frozen=True)
class Bar:
    """A slender bar along x with an interface at x = 0 and no Poisson effect, so that bar theory is exact."""

    body: FlexibleBody
    length: float
    axial_stiffness: float
    mass_per_length: float


@pytest.fixture(scope="session")
def bar():
    length, width, height, modulus, density = 1.0, 0.05, 0.04, 7e10, 2700.0
    mesh = block(length, width, height, 10, 1, 1, CellType.HEXA20)
    model = solid_model(mesh, Isotropic(modulus, 0.0, density))
    body = flexible_body("bar", model, (RigidInterface("root", "root"),))
    return Bar(body, length, modulus * width * height, density * width * height)


def _exact_eigenvalues(body, n_values, *, clamped=False, added_mass=None):
    """Lowest eigenvalues of the full body: free (elastic ones), clamped at its interfaces or loaded there."""
    B = motion_rows(body.interfaces)
    mass = body.mass if added_mass is None else sparse.csc_array(body.mass + B.T @ added_mass @ B)
    constraint = B if clamped else (mass @ body.rigid_modes).T
    return lowest_modes(body.stiffness, mass, n_values, constraint=constraint).values


@pytest.fixture(scope="session")
def exact_eigenvalues():
    return _exact_eigenvalues


@pytest.fixture(scope="session")
def added_mass(solid_body):
    """Rigid bodies at both interfaces of the block, each of about half its mass."""
    one = np.diag([150.0, 150.0, 150.0, 8.0, 60.0, 60.0])
    return linalg.block_diag(one, one)
