"""The locking indicator against full models, in statics, and what condensation leaves of locking."""

from __future__ import annotations

import numpy as np
import pytest
from fixtures.beam_bodies import beam_body

from supple.body import MeanAxisFrame, NodalFixedFrame, RigidInterface, flexible_body
from supple.body.rigid_motion import nodal_rigid_modes
from supple.errors import LockingWarning
from supple.fem import HomogeneousSection, Isotropic, shell_model, solid_model
from supple.mesh import CellType, block, strip
from supple.reduction import (
    CompressedDerivatives,
    CraigBampton,
    Locking,
    NoDerivatives,
    NoLoads,
    NormalModes,
    PlainQuartic,
    Rubin,
    internal_force_tensors,
    project,
    reduce,
    reduction_basis,
)
from supple.reduction.locking import _loads

THICKNESS = 0.006**0.5


def full_answer(body, frame, load):
    """Newton's method in two steps on f(q) + D^T mu = F, D q = 0, dense."""
    D = frame.constraint(body)
    D = D * body.stiffness.diagonal().max() / np.abs(D).max()
    q, mu = np.zeros(body.n), np.zeros(6)
    for share in (0.5, 1.0):
        for _ in range(30):
            residual = np.concatenate([body.assembly.internal_force(q) + D.T @ mu - share * load, D @ q])
            tangent = np.block([[body.assembly.tangent(q).toarray(), D.T], [D, np.zeros((6, 6))]])
            step = np.linalg.solve(tangent, -residual)
            q, mu = q + step[: body.n], mu + step[body.n :]
            if np.abs(step[: body.n]).max() < 1e-8 * np.abs(q).max():
                break
        else:
            raise AssertionError("Newton's method did not converge")
    return q


def strip_of(*interfaces: str, n_length: int = 8):
    material = Isotropic(2.8e7 / (THICKNESS * 0.5), 0.0, 1.2 / (THICKNESS * 0.5))
    model = shell_model(strip(10.0, 0.5, n_length, 2), HomogeneousSection(material, THICKNESS))
    return flexible_body("strip", model, [RigidInterface(name, name) for name in interfaces])


def solid_of(*interfaces: str):
    model = solid_model(block(4.0, 0.3, 0.1, 6, 1, 1, CellType.HEXA20), Isotropic(1e7, 0.3, 1000.0))
    return flexible_body("bar", model, [RigidInterface(name, name) for name in interfaces])


MEAN_AXIS, ROOT = MeanAxisFrame(), NodalFixedFrame("root")
CASES = {
    "strip, mean-axis": (lambda: strip_of("root"), MEAN_AXIS, Rubin(n_columns=10), CompressedDerivatives(4)),
    "strip, fixed": (lambda: strip_of("root"), ROOT, CraigBampton(n_modes=10), NoDerivatives()),
    "link": (lambda: strip_of("root", "tip"), MEAN_AXIS, CraigBampton(n_modes=6), CompressedDerivatives(5)),
    "beams, mean-axis": (
        lambda: beam_body("root"),
        MEAN_AXIS,
        Rubin(n_columns=10),
        CompressedDerivatives(4),
    ),
    "beams, fixed": (lambda: beam_body("root", "tip"), ROOT, CraigBampton(n_modes=6), NoDerivatives()),
    "solid, mean-axis": (lambda: solid_of("root"), MEAN_AXIS, Rubin(n_modes=6), CompressedDerivatives(5)),
    "solid, fixed": (lambda: solid_of("root", "tip"), ROOT, CraigBampton(n_modes=5), NoDerivatives()),
}

BENT_ALONE = 2 * (1 / 5 - 2 / 8 + 1 / 11) / (1 / 5)
"""What N(q, z) withholds of the work of a uniform load on a cantilever, per square of the turn of its tip.

Condensed columns that only bend leave it out. An inextensible beam has the energy 1/2 EI w''^2 / (1 - w'^2);
its fourth-order part U4 = 1/2 EI int w''^2 w'^2 takes 4 U4 / (2 U2) of the work to first order, where
w' = theta (1 - s^3), s = 1 - x/L.
"""
WITHHELD = {"strip, fixed": BENT_ALONE}


@pytest.mark.parametrize("name", CASES)
def test_condensed_bodies_do_not_lock_and_the_indicator_says_by_how_much_others_do(name):
    """Against the full model in the same frame, under its inertia across its plane, turned by 0.1 rad."""
    make, frame, recipe, derivatives = CASES[name]
    body = make()
    basis = reduction_basis(body, frame, recipe, derivatives=derivatives)
    V = basis.vectors
    plain = internal_force_tensors(body, V)
    small = project(body, basis)
    found = locking_of(small)
    force = accelerated(body)
    index = found.loads.index("acceleration z")
    load = _loads(body, V, plain.stiffness)[1][index]
    force = force * (load @ (V.T @ force)) / np.sum((V.T @ force) ** 2)
    np.testing.assert_allclose(V.T @ force, load, atol=1e-6 * np.abs(load).max())
    full = force @ full_answer(body, frame, force)
    locked, condensed = (float(load @ answer(tensors, load)) for tensors in (plain, small.tensors))
    true = 1 - locked / full
    assert true > 0.02
    linear = V @ np.linalg.solve(plain.stiffness, load)
    turns = (body.rotation_operator @ (body.expansion @ linear)).reshape(-1, 3)
    turn = np.linalg.norm(turns - body.interfaces[0].motion[3:] @ linear, axis=1).max()
    assert abs(condensed * (1 - WITHHELD.get(name, 0.0) * turn**2) / full - 1) < 1e-3
    assert true / 1.5 < found.plain[index] < true * 1.5
    assert found.remaining[index] == 0.0


@pytest.mark.parametrize(
    ("frame", "derivatives", "allowed"),
    [
        (MEAN_AXIS, NoDerivatives(), 0.01),
        (MEAN_AXIS, CompressedDerivatives(5), 2e-3),
        (ROOT, NoDerivatives(), 5e-3),
    ],
)
def test_condensed_beams_bend_far_about_both_axes_at_once(frame, derivatives, allowed):
    """By 0.3 rad, nine times as far about the weak axis: bending, torsion and stretch are all coupled.

    What is left is N(q, z), a share of theta^2 = 0.09 of the work; the columns alone are a fifth or more off.
    """
    body = beam_body("root", "tip")
    basis = reduction_basis(body, frame, CraigBampton(n_modes=6), derivatives=derivatives)
    V = basis.vectors
    plain = internal_force_tensors(body, V)
    force = accelerated(body, 1) + accelerated(body, 2)
    linear = V @ np.linalg.solve(plain.stiffness, V.T @ force)
    turns = (body.rotation_operator @ (body.expansion @ linear)).reshape(-1, 3)
    turn = np.linalg.norm(turns - body.interfaces[0].motion[3:] @ linear, axis=1).max()
    force *= 0.3 / turn
    full = force @ full_answer(body, frame, force)
    load = V.T @ force
    locked, condensed = (
        float(load @ answer(tensors, load)) for tensors in (plain, project(body, basis).tensors)
    )
    assert locked < 0.8 * full
    assert abs(condensed / full - 1) < allowed


def locking_of(reduced) -> Locking:
    assert reduced.report.locking is not None
    return reduced.report.locking


def accelerated(body, axis=2):
    """Inertia of a unit acceleration along an axis, z by default, reacted at the root."""
    held, R = body.interfaces[0].motion.toarray(), body.rigid_modes
    nodal = nodal_rigid_modes(body.nodes, body.dofs_per_node)[:, axis]
    force = body.expansion.T @ (body.nodal_mass @ nodal)
    return force - held.T @ np.linalg.solve((held @ R).T, R.T @ force)


def answer(tensors, load):
    """Newton's method of few unknowns, the load in steps."""
    gamma = np.zeros(tensors.r)
    for share in np.linspace(0, 1, 9)[1:]:
        for _ in range(30):
            gamma += np.linalg.solve(tensors.tangent(gamma), share * load - tensors.internal_force(gamma))
    return gamma


@pytest.fixture(scope="module")
def link():
    return strip_of("root", "tip", n_length=6)


def test_plain_tensors_earn_a_warning_with_the_remedy(link):
    with pytest.warns(LockingWarning, match=r"body 'strip' locks: under .* too small; .*CondensedQuartic"):
        locked = reduce(
            link,
            MEAN_AXIS,
            Rubin(n_modes=4),
            derivatives=NoDerivatives(),
            quartic=PlainQuartic(),
            loads=NoLoads,
        )
    free = reduce(link, MEAN_AXIS, Rubin(n_modes=4), derivatives=NoDerivatives(), loads=NoLoads)
    assert locking_of(locked).largest_remaining > 0.2
    np.testing.assert_allclose(locking_of(locked).plain, locking_of(free).plain, rtol=1e-12)
    np.testing.assert_array_equal(locking_of(locked).plain, locking_of(locked).remaining)
    assert locking_of(free).largest_remaining == 0.0


def test_a_basis_without_its_interfaces_static_shapes_still_locks_and_says_so(link):
    """Vibrations of the free strip: nothing condensed moves the tip towards the root, which joints see."""
    with pytest.warns(LockingWarning, match="lacks the static shapes of its interfaces"):
        small = reduce(link, MEAN_AXIS, NormalModes(6), derivatives=NoDerivatives(), loads=NoLoads)
    found = locking_of(small)
    assert 0.2 < found.largest_remaining <= found.largest_plain


def test_a_body_without_interfaces_is_pushed_along_its_shapes():
    small = reduce(
        strip_of(n_length=6), MEAN_AXIS, NormalModes(6), derivatives=NoDerivatives(), loads=NoLoads
    )
    found = locking_of(small)
    assert found.loads[0] == "push along shape 1"
    assert found.largest_plain > 0.2
    assert found.largest_remaining == 0.0


def test_the_indicator_reads_as_a_sentence():
    found = Locking(("acceleration x", "acceleration z"), np.array([np.nan, 0.1]), np.zeros(2))
    assert str(found) == "none of the response at 0.1 rad; without condensation 10 %, under acceleration z"
