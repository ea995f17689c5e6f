from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import sparse

from supple.algebra import count_below
from supple.body import MeanAxisFrame, RigidInterface, flexible_body, superelement
from supple.errors import AccuracyError
from supple.fem import HomogeneousSection, Isotropic, shell_model, solid_model
from supple.mesh import CellType, block, cylinder, strip
from supple.reduction import CraigBamptonFamily, enclose_eigenvalues

N = 10


@pytest.fixture(scope="module")
def body():
    """A square-symmetric cylinder: its bending eigenvalues come in pairs."""
    model = solid_model(cylinder(0.1, 1.0, 2, 1, 8, CellType.HEXA8), Isotropic(1e9, 0.3, 1000.0))
    return flexible_body("cylinder", model, [RigidInterface("root", "root")])


@pytest.fixture(scope="module")
def exact(body, lowest_squares):
    return lowest_squares(body, MeanAxisFrame(), 20)


@pytest.fixture(scope="module")
def trial(body):
    family = CraigBamptonFamily(body)
    return family.vectors(family.vibrations(30, 20))


def test_every_eigenvalue_is_enclosed_pairs_too(body, exact, trial):
    assert exact[1] / exact[0] - 1 < 1e-6
    enclosure = enclose_eigenvalues(body, trial, N, 1e-4)
    assert np.all(enclosure.lower <= exact[:N] * (1 + 1e-9))
    assert np.all(enclosure.upper >= exact[:N] * (1 - 1e-9))
    assert np.max(enclosure.upper / enclosure.lower - 1) < 1e-4
    assert enclosure.n_below == 6 + np.sum(exact < enclosure.shift)


@pytest.mark.parametrize("width", [1e-2, 1e-5, 1e-8])
def test_the_bounds_are_as_close_as_one_asks(body, exact, trial, width):
    enclosure = enclose_eigenvalues(body, trial, N, width)
    assert np.max(enclosure.upper / enclosure.lower - 1) <= width
    np.testing.assert_allclose(enclosure.lower, exact[:N], rtol=width + 1e-9)


@pytest.mark.parametrize("width", [1e-2, 1e-6])
def test_a_mode_that_the_trial_motions_lack_is_found(monkeypatch, body, exact, width):
    """The count objects once; then random motions bring the mode that was taken away."""
    counts = []

    def counted(*arguments, **options):
        counts.append(count_below(*arguments, **options))
        return counts[-1]

    monkeypatch.setattr("supple.reduction.eigenvalues.eigenvalue_enclosure.count_below", counted)
    family = CraigBamptonFamily(body)
    everything = family.vectors(family.vibrations(family.n_available, 22))
    enclosure = enclose_eigenvalues(body, np.delete(everything, 2, axis=1), N, width)
    assert len(counts) == 2
    assert np.all(enclosure.lower <= exact[:N] * (1 + 1e-9))
    np.testing.assert_allclose(enclosure.lower, exact[:N], rtol=width)


def test_bounds_closer_than_round_off_are_refused(body, trial):
    with pytest.raises(AccuracyError, match=r"not be enclosed to 1e-20 \(bounds .* apart\); give more trial"):
        enclose_eigenvalues(body, trial, N, 1e-20)


@pytest.fixture(scope="module")
def rotor():
    """Twelve equal bars on a rigid hub: each elastic eigenvalue of a clamped bar comes nine times or more."""
    bar = block(1.0, 0.1, 0.09, 4, 1, 1, CellType.HEXA8)
    blades, nodes = [], []
    for angle in 2 * np.pi * np.arange(12) / 12:
        turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
        nodes.append((bar.nodes + np.array([0.3, 0, 0])) @ turn.T)
        model = solid_model(replace(bar, nodes=nodes[-1]), Isotropic(7e10, 0.3, 2700.0))
        blades.append(flexible_body("blade", model))
    hub = np.concatenate([bar.nodes_of("root") + i * len(bar.nodes) for i in range(12)])
    stiffness, mass = (
        sparse.block_diag([getattr(blade, name) for blade in blades], format="csc")
        for name in ("stiffness", "mass")
    )
    return superelement(
        "rotor", np.vstack(nodes), stiffness, mass, dofs_per_node=3, interfaces=[RigidInterface("hub", hub)]
    )


def test_a_cluster_larger_than_the_trial_motions(rotor, lowest_squares):
    """The tenth eigenvalue is the first of nine equal ones; fourteen trial motions do not see their end."""
    exact = lowest_squares(rotor, MeanAxisFrame(), 21)
    assert exact[17] / exact[9] - 1 < 1e-9 < 0.1 < exact[9] / exact[8] - 1
    family = CraigBamptonFamily(rotor)
    enclosure = enclose_eigenvalues(rotor, family.vectors(family.vibrations(20, 14)), N, 1e-6)
    np.testing.assert_allclose(enclosure.lower, exact[:N], rtol=1e-6)
    assert enclosure.n_below == 6 + np.sum(exact < enclosure.shift) >= 6 + 18


def test_motions_so_stiff_that_they_are_round_off_do_no_harm(lowest_squares):
    """A foil's drilling and membrane motions have inverse eigenvalues 10^-16 of its lowest bending one."""
    model = shell_model(strip(10.0, 0.4, 8, 2), HomogeneousSection(Isotropic(7e10, 0.3, 2700.0), 1e-3))
    foil = flexible_body("foil", model, [RigidInterface("root", "root")])
    trial = np.random.default_rng(0).standard_normal((foil.n, 120))
    enclosure = enclose_eigenvalues(foil, trial, 6, 1e-5)
    np.testing.assert_allclose(enclosure.lower, lowest_squares(foil, MeanAxisFrame(), 6), rtol=1e-4)


def test_every_number_of_eigenvalues_of_a_cube(lowest_squares):
    """Pairs and triples, cut anywhere, up to all eigenvalues but one."""
    model = solid_model(block(1.0, 1.0, 1.0, 1, 1, 1, CellType.HEXA8), Isotropic(1e7, 0.3, 1000.0))
    cube = flexible_body("cube", model)
    exact = lowest_squares(cube, MeanAxisFrame(), 18)
    assert np.sum(np.diff(exact) < 1e-9 * exact[:-1]) > 5
    trial = np.random.default_rng(0).standard_normal((24, 19))
    for n_values in range(1, 18):
        enclosure = enclose_eigenvalues(cube, trial[:, : n_values + 2], n_values, 1e-6)
        np.testing.assert_allclose(enclosure.lower, exact[:n_values], rtol=1e-6)
