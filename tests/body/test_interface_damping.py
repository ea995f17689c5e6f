"""Damping against an interface: what is asked of the modes held there is what they have, in every frame."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from fixtures.beam_bodies import beam_body

from supple.body import (
    FullBody,
    LinearRayleighDamping,
    MeanAxisFrame,
    ModalDamping,
    NodalFixedFrame,
    RayleighDamping,
    rayleigh_at_modes,
)
from supple.errors import ModelError
from supple.methods.floating.full.full_damping import full_damping
from supple.reduction import CompleteBasis, CraigBampton, NoDerivatives, NoLoads, clamped_modes, reduce

FRAMES = {
    "held": NodalFixedFrame("root"),
    "mean-axis": MeanAxisFrame(),
    "other-end": NodalFixedFrame("tip"),
}
RATIO = 0.02


@pytest.fixture(scope="module")
def nonlinear():
    return beam_body("root", "tip", n=3, length=4.0)


@pytest.fixture(scope="module")
def body(nonlinear):
    return nonlinear.linearized()


@pytest.fixture(params=FRAMES)
def frame(request):
    return FRAMES[request.param]


def fitted(body, held="root"):
    """Two per cent of the first and the third mode held at the root; the second is the first, about z."""
    constraint = NodalFixedFrame("root").constraint(body)
    return replace(rayleigh_at_modes(body.stiffness, body.mass, constraint, RATIO, (1, 3)), held=held)


def dense(damping):
    """D of a full body at rest, (n, n), without what follows the strain rate."""
    return np.array([damping.force(unit) for unit in np.eye(damping.full.body.n)]).T


def reduced_to_all(body, frame, damping):
    return reduce(body, frame, CompleteBasis(), derivatives=NoDerivatives(), damping=damping, loads=NoLoads)


@pytest.mark.parametrize("kind", ["rayleigh", "linear", "modal"])
def test_the_held_modes_have_the_ratio_that_is_asked_for(nonlinear, frame, kind):
    body = nonlinear if kind == "rayleigh" else nonlinear.linearized()
    damping = {
        "rayleigh": lambda: fitted(body),
        "linear": lambda: fitted(body).linearized(),
        "modal": lambda: ModalDamping(RATIO, held="root"),
    }[kind]()
    reduced = reduce(
        body, frame, CraigBampton(8), derivatives=NoDerivatives(), damping=damping, loads=NoLoads
    )
    found = clamped_modes(reduced, "root", n_modes=3).damping_ratios
    wanted = [RATIO] * 3 if kind == "modal" else [RATIO, found[1], RATIO]
    np.testing.assert_allclose(found, wanted, rtol=1e-4)


def test_against_mean_axes_the_first_held_mode_is_damped_far_less(body):
    """What `held` is for: alpha M misses most of a mode whose motion the frame takes part in."""
    for damping in (fitted(body, held=None), ModalDamping(RATIO)):
        reduced = reduced_to_all(body, MeanAxisFrame(), damping)
        assert clamped_modes(reduced, "root", n_modes=1).damping_ratios[0] < 0.3 * RATIO


def test_a_full_body_has_the_mass_seen_from_the_interface(body, frame):
    """D = alpha P^T M P, P = I - R G, but for forces that hold the frame: V^T D V of motions in it."""
    G = body.interface("root").motion.toarray()
    P = np.eye(body.n) - body.rigid_modes @ np.linalg.solve(G @ body.rigid_modes, G)
    expected = 0.3 * P.T @ body.mass.toarray() @ P
    damping = full_damping(FullBody(body, frame, RayleighDamping(0.3, 0.0, held="root")))
    V = reduced_to_all(body, frame, None).nodal_basis
    V = np.linalg.lstsq(body.expansion.toarray(), V, rcond=None)[0]
    D = dense(damping)
    np.testing.assert_allclose(V.T @ D @ V, V.T @ expected @ V, atol=1e-9 * 0.3)
    if frame != FRAMES["held"]:
        np.testing.assert_allclose(D, expected, atol=1e-9 * abs(expected).max())
        np.testing.assert_allclose(D @ body.rigid_modes, 0.0, atol=1e-9 * abs(expected).max())


@pytest.mark.parametrize(
    "damping", [RayleighDamping(0.3, 0.0, held="root"), ModalDamping([0.02, 0.1], n_modes=5, held="root")]
)
def test_full_and_reduced_bodies_are_damped_alike(body, frame, damping):
    reduced = reduced_to_all(body, frame, damping)
    V = np.linalg.lstsq(body.expansion.toarray(), reduced.nodal_basis, rcond=None)[0]
    D = dense(full_damping(FullBody(body, frame, damping)))
    np.testing.assert_allclose(V.T @ D @ V, reduced.damping, atol=1e-7 * abs(reduced.damping).max())


def test_in_the_frame_of_the_interface_nothing_changes(body):
    frame = FRAMES["held"]
    for damping in (RayleighDamping(0.3, 1e-4), LinearRayleighDamping(0.3, 1e-4), ModalDamping(0.02)):
        own, seen = (
            reduced_to_all(body, frame, each).damping for each in (damping, replace(damping, held="root"))
        )
        np.testing.assert_allclose(seen, own, atol=1e-9 * abs(own).max())


def test_an_interface_that_the_body_lacks(body):
    with pytest.raises(ModelError, match=r"no interface 'rot'.*root"):
        reduced_to_all(body, MeanAxisFrame(), RayleighDamping(0.3, 0.0, held="rot"))
    with pytest.raises(ModelError, match=r"no interface 'rot'.*root"):
        full_damping(FullBody(body, MeanAxisFrame(), ModalDamping(0.02, n_modes=3, held="rot")))
