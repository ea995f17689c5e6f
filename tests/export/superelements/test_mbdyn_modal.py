"""MBDyn's invariants are its own definitions of them, summed over the mesh."""

import re

import numpy as np
import pytest

from supple.body import AveragingInterface, MeanAxisFrame, flexible_body
from supple.export import write_mbdyn
from supple.reduction import CraigBampton, NoDerivatives, NoLoads, reduce


@pytest.fixture(scope="module")
def of_points(model):
    body = flexible_body("points", model, [AveragingInterface(name, name) for name in ("root", "tip")])
    return reduce(
        body.linearized(),
        MeanAxisFrame(),
        CraigBampton(n_modes=1),
        derivatives=NoDerivatives(),
        loads=NoLoads,
    )


def groups(path):
    """Numbers of each record group."""
    parts = re.split(r"\*\* RECORD GROUP (\d+),", path.read_text())
    numbers = {}
    for number, text in zip(parts[1::2], parts[2::2], strict=True):
        rows = [line for line in text.splitlines()[1:] if not line.startswith("**")]
        numbers[int(number)] = np.array([float(x) for x in " ".join(rows).split() if not x.startswith("REV")])
    return numbers


def test_modes_matrices_and_inertia_are_those_of_the_body(of_points, tmp_path):
    r, found = of_points.r, groups(write_mbdyn(tmp_path / "body.fem", of_points))
    assert found[1].tolist() == [2, r, 0, 0, 0]
    shapes = found[8].reshape(r, 2, 6)
    for number, interface in enumerate(of_points.interfaces):
        np.testing.assert_array_equal(shapes[:, number].T, interface.motion)
        np.testing.assert_array_equal([found[5 + i][number] for i in range(3)], interface.position)
    np.testing.assert_allclose(found[9].reshape(r, r), np.eye(r), atol=1e-9)
    np.testing.assert_array_equal(found[10].reshape(r, r), of_points.stiffness)
    mass, centre, inertia = found[12][0], found[12][1:4], found[12][4:].reshape(3, 3)
    assert mass == pytest.approx(7800.0 * 0.02, rel=1e-9)
    np.testing.assert_allclose(centre, [0.5, 0.0, 0.0], atol=1e-9)
    expected = mass / 12 * np.array([0.2**2 + 0.1**2, 1.0 + 0.1**2, 1.0 + 0.2**2])
    np.testing.assert_allclose(inertia, np.diag(expected), atol=1e-9 * mass)


def test_invariants_are_sums_over_the_mesh(model, of_points, tmp_path):
    r, found = of_points.r, groups(write_mbdyn(tmp_path / "body.fem", of_points))
    V, x = of_points.nodal_basis.reshape(-1, 3, r), of_points.nodes
    N = len(x)
    m = model.mass.toarray().reshape(N, 3, N, 3)[:, 0, :, 0]  # of every direction alike
    cross = np.zeros((3, 3, 3))
    cross[0, 1, 2] = cross[1, 2, 0] = cross[2, 0, 1] = 1.0
    cross[0, 2, 1] = cross[2, 1, 0] = cross[1, 0, 2] = -1.0
    x_cross = np.einsum("ajb,nj->nab", cross, x)  # x~
    modes = np.einsum("ajb,njk->nabk", cross, V)
    expected = {
        14: np.einsum("nm,mak->ak", m, V),
        15: np.einsum("nm,nab,mbk->ak", m, x_cross, V),
        16: -np.einsum("nm,nab,mbck->akc", m, x_cross, modes),
        17: np.einsum("nm,nabi,mbj->aij", m, modes, V),
        18: np.einsum("nm,nabj,mbck->ajkc", m, modes, modes),
    }
    for group, values in expected.items():
        atol = 1e-10 * max(abs(values).max(), 1.0)
        np.testing.assert_allclose(found[group], values.ravel(), atol=atol, err_msg=str(group))
