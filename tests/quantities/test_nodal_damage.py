"""Damage at nodes from stress modes: closed forms of bars, criterion against criterion, part by part."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from supple.errors import ModelError
from supple.fatigue import Goodman, SNCurve, miner_damage, rainflow
from supple.quantities import CriticalPlane, SignedVonMises, hot_spot_damage, strain_modes, stress_modes

CURVE = SNCurve(100e6, 2e6, 4.0)
UNTURNED = np.eye(3)
COSINE = np.cos(np.pi * np.arange(41))


def tensors(principal, turned):
    """(t, 6) of principal stresses (t, 3) along the columns of a rotation."""
    full = np.einsum("ia,ta,ja->tij", turned, principal, turned)
    return np.stack([full[:, i, j] for i, j in ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))], axis=1)


def worst(criterion, stress):
    histories = criterion.histories(stress[:, None])[:, 0]
    assert histories.shape[1] == criterion.n_histories
    return miner_damage(rainflow(histories), CURVE).max()


def uniaxial(turned=UNTURNED):
    return tensors(np.stack([50e6 * COSINE, 0 * COSINE, 0 * COSINE], axis=1), turned)


EXACT = 20 * CURVE.damage(100e6)


@pytest.mark.parametrize("degrees", [5.0, 10.0, 30.0])
def test_no_direction_is_further_from_a_plane_than_is_said(degrees):
    random = np.random.default_rng(0).standard_normal((5000, 3))
    directions = random / np.linalg.norm(random, axis=1)[:, None]
    plane = CriticalPlane(np.radians(degrees))
    assert np.linalg.norm(plane.normals, axis=1) == pytest.approx(1.0)
    nearest = np.abs(directions @ plane.normals.T).max(axis=1)
    assert np.degrees(np.arccos(nearest.min())) <= degrees / np.sqrt(2)


def test_uniaxial_stress_in_any_direction():
    assert worst(CriticalPlane(), uniaxial()) == pytest.approx(EXACT, rel=1e-12)
    assert worst(SignedVonMises(), uniaxial()) == pytest.approx(EXACT, rel=1e-12)
    for turned in Rotation.random(20, rng=1).as_matrix():
        assert EXACT * (1 - 0.0152) ** 4 <= worst(CriticalPlane(), uniaxial(turned)) <= EXACT * (1 + 1e-12)
        assert worst(SignedVonMises(), uniaxial(turned)) == pytest.approx(EXACT, rel=1e-9)


def test_a_turning_principal_axis_does_damage_that_its_signed_size_hides():
    """Tension of constant size that turns in the plane: von Mises stands still, every plane fatigues."""
    turn = np.linspace(0, 20 * np.pi, 2001)
    stress = np.zeros((len(turn), 6))
    stress[:, 0], stress[:, 1] = 100e6 * np.cos(turn) ** 2, 100e6 * np.sin(turn) ** 2
    stress[:, 5] = 100e6 * np.cos(turn) * np.sin(turn)
    assert worst(SignedVonMises(), stress) < 1e-9 * EXACT
    # On each plane in it 100e6 (1 + cos 2(turn - plane)) / 2: the range of 20 cycles is 100e6.
    assert worst(CriticalPlane(), stress) == pytest.approx(EXACT, rel=0.03)


@pytest.fixture
def bent(blade, clamped_blade):
    history = 0.02 * np.random.default_rng(2).standard_normal((60, clamped_blade.r))
    return clamped_blade, blade.model, history / clamped_blade.frequencies


@pytest.mark.parametrize(
    "criterion", [CriticalPlane(np.radians(30)), SignedVonMises()], ids=["plane", "mises"]
)
def test_damage_of_a_blade_is_that_of_its_recovered_stress(bent, criterion, monkeypatch):
    """Node by node and face by face; and the same in parts of one node."""
    body, model, history = bent
    nodes = [0, 7, 20]
    modes = stress_modes(body, model, nodes)
    scale = 60e6 / np.abs(modes.at(history)).max()
    curve = SNCurve(100e6 / scale, 2e6, 4.0)
    found = hot_spot_damage(modes, history, curve, criterion)
    stress = modes.at(history)[:, :, [0, 2]]
    expected = [
        max(
            miner_damage(rainflow(criterion.histories(stress[:, [k], face])[:, 0]), curve).max()
            for face in (0, 1)
        )
        for k in range(3)
    ]
    assert found == pytest.approx(expected, rel=1e-12)
    assert found.min() > 0
    monkeypatch.setattr("supple.quantities.nodal_damage._NUMBERS", 1)
    assert hot_spot_damage(modes, history, curve, criterion) == pytest.approx(found, rel=1e-12)
    mean = hot_spot_damage(modes, history, curve, criterion, correction=Goodman(1e3 * scale * 60e6))
    assert (mean > found).all()


def test_what_has_no_damage_is_refused(bent):
    body, model, history = bent
    with pytest.raises(ModelError, match="strain"):
        hot_spot_damage(strain_modes(body, model, [0]), history, CURVE)
    modes = stress_modes(body, model, [0])
    with pytest.raises(ModelError, match=r"\(t, r\)"):
        hot_spot_damage(modes, history[0], CURVE)
    with pytest.raises(ModelError, match="coordinates"):
        hot_spot_damage(modes, history[:, :-1], CURVE)
    with pytest.raises(ModelError, match="finite"):
        hot_spot_damage(modes, np.where(np.arange(60)[:, None] == 9, np.nan, history), CURVE)
    with pytest.raises(ModelError, match="rad"):
        CriticalPlane(10.0)
