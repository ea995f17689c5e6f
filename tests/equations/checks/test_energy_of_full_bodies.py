"""Energies and momenta of bodies with all their freedoms: against complete bases, and what motion keeps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import csc_array, eye_array, kron

from supple.body import (
    FullBody,
    MeanAxisFrame,
    NodalFixedFrame,
    RigidBody,
    RigidInterface,
    flexible_body,
)
from supple.equations import balances, joint_residuals
from supple.equations.checks import energy
from supple.equations.full_inertia import cross_matrix
from supple.errors import LockingWarning
from supple.fem import HomogeneousSection, Isotropic, shell_model, solid_model
from supple.integrate import FixedStep, FloatingMotion, Newmark, Run, Solution, Statistics, Tolerances
from supple.machine import GROUND, At, Ball, Placed, Revolute, System
from supple.mesh import CellType, block, strip
from supple.reduction import CompleteBasis, NoDerivatives, NormalModes, project, reduction_basis
from supple.simulation import simulate

GRAVITY = np.array([0.3, -0.2, -9.81])
FRAMES = {"nodal-fixed": NodalFixedFrame("root"), "mean-axis": MeanAxisFrame()}
ENDS = (RigidInterface("root", "root"), RigidInterface("tip", "tip"))
MASS = 40.0
"""Of the solid arm, kg."""


def solid():
    return solid_model(block(1.0, 0.2, 0.2, 3, 1, 1, CellType.TETRA4), Isotropic(5e5, 0.3, 1000.0))


def shell():
    return shell_model(strip(1.0, 0.1, 2, 2), HomogeneousSection(Isotropic(1e7, 0.3, 1000.0), 0.02))


MODELS = {"solid": solid, "shell": shell}


@pytest.fixture(scope="module", params=MODELS)
def nonlinear(request):
    return flexible_body("arm", MODELS[request.param](), ENDS)


@pytest.fixture(params=["nonlinear", "linear"])
def body(request, nonlinear):
    return nonlinear if request.param == "nonlinear" else nonlinear.linearized()


@pytest.fixture(params=FRAMES)
def basis(request, body):
    """All modes of the body in a frame."""
    return reduction_basis(body, FRAMES[request.param], CompleteBasis(), derivatives=NoDerivatives())


def motion_of(basis, turned):
    """Four instants of a random motion, in the coordinates of the basis."""
    rng = np.random.default_rng(4)
    r, t = basis.vectors.shape[1], 4
    return FloatingMotion(
        position=rng.standard_normal((t, 3)),
        rotation=np.array([turned(0, 0.4 * k) @ turned(2, -1.1 * k) for k in range(t)]),
        coordinates=0.1 * rng.standard_normal((t, r)),
        velocity=rng.standard_normal((t, 3)),
        angular_velocity=rng.standard_normal((t, 3)),
        coordinate_rates=rng.standard_normal((t, r)),
        acceleration=np.zeros((t, 3)),
        angular_acceleration=np.zeros((t, 3)),
        coordinate_accelerations=np.zeros((t, r)),
    )


def in_all_freedoms(basis, motion):
    """The same motion with the coordinates `q = V gamma`."""
    nodal = {
        name: getattr(motion, name) @ basis.vectors.T
        for name in ("coordinates", "coordinate_rates", "coordinate_accelerations")
    }
    return FloatingMotion(**(vars(motion) | nodal))


def kept_by(body, motion):
    system = System((Placed(body),), gravity=GRAVITY)
    return balances(system, Solution(np.arange(len(motion.position)), {body.name: motion}, {}, Statistics()))


def assert_equal(actual, expected, rtol):
    for name, values in expected._asdict().items():
        np.testing.assert_allclose(
            getattr(actual, name), values, rtol=0, atol=rtol * np.abs(values).max(), err_msg=name
        )


def test_a_full_body_has_the_energies_of_its_complete_basis(body, basis, turned):
    """One motion in two coordinates: sums over nodes and elements against Gram matrix and tensors."""
    motion = motion_of(basis, turned)
    full = FullBody(body, basis.frame)
    assert_equal(
        kept_by(full, in_all_freedoms(basis, motion)), kept_by(project(body, basis), motion), rtol=1e-10
    )


def test_energies_do_not_depend_on_how_many_instants_are_held(body, basis, turned, monkeypatch):
    full, motion = FullBody(body, basis.frame), in_all_freedoms(basis, motion_of(basis, turned))
    together = kept_by(full, motion)
    monkeypatch.setattr(energy, "_FIELD_NUMBERS", 1)
    assert_equal(kept_by(full, motion), together, rtol=1e-14)


def test_potential_energy_of_a_full_body_is_that_of_its_weights(body, turned):
    """At nodes that carry no moment by their weight, `-sum f . r` over the nodes."""
    basis = reduction_basis(body, MeanAxisFrame(), CompleteBasis(), derivatives=NoDerivatives())
    motion = in_all_freedoms(basis, motion_of(basis, turned))
    full = FullBody(body, MeanAxisFrame())
    place = full.nodes + full.expand(motion.coordinates)
    place = motion.position[:, None] + np.einsum("tij,tnj->tni", motion.rotation, place)
    field = np.zeros((len(full.nodes), body.dofs_per_node))
    field[:, :3] = GRAVITY
    weights = (body.nodal_mass @ field.ravel()).reshape(field.shape)[:, :3]
    np.testing.assert_allclose(
        kept_by(full, motion).potential, -np.einsum("ni,tni->t", weights, place), rtol=1e-11
    )


def test_gravity_works_on_the_momentum_of_masses_off_their_nodes(blade, turned):
    """`dU/dt = -g . P` without spin, exact over a whole step; the masses couple translations to rotations."""
    shift = np.eye(6)
    shift[:3, 3:] = -cross_matrix(np.array([0.02, -0.01, 0.03]))
    shifts = csc_array(kron(eye_array(len(blade.nodes)), shift))
    nodal_mass = csc_array(shifts.T @ blade.nodal_mass @ shifts)
    body = replace(
        blade, nodal_mass=nodal_mass, mass=csc_array(blade.expansion.T @ nodal_mass @ blade.expansion)
    )
    basis = reduction_basis(body, MeanAxisFrame(), NormalModes(3), derivatives=NoDerivatives())
    start = motion_of(basis, turned).at(slice(1, 2))
    still = replace(start, angular_velocity=np.zeros((1, 3)))
    after = replace(
        still,
        position=still.position + still.velocity,
        coordinates=still.coordinates + still.coordinate_rates,
    )
    with pytest.warns(LockingWarning, match="lacks the static shapes of its interfaces"):
        reduced = project(body, basis)
    for own, in_its_coordinates in (
        (reduced, lambda motion: motion),
        (FullBody(body, MeanAxisFrame()), lambda motion: in_all_freedoms(basis, motion)),
    ):
        first, second = (kept_by(own, in_its_coordinates(motion)) for motion in (still, after))
        np.testing.assert_allclose(second.potential - first.potential, -first.momentum @ GRAVITY, rtol=1e-10)


@pytest.fixture(scope="module", params=FRAMES)
def complete(request):
    """All modes of the soft solid arm in a frame."""
    frame = FRAMES[request.param]
    return reduction_basis(soft_arm(), frame, CompleteBasis(), derivatives=NoDerivatives())


def soft_arm():
    return flexible_body("arm", solid(), ENDS)


@pytest.fixture
def arm(complete):
    """The soft solid arm with all its freedoms, in the same frame."""
    return FullBody(soft_arm(), complete.frame)


def run(system, duration, step):
    """The trapezoidal rule: it takes no energy on purpose."""
    return simulate(
        system,
        Run(
            duration=duration,
            output_step=0.02,
            step=FixedStep(step),
            method=Newmark(),
            tolerances=Tolerances(residual=1e-11),
        ),
    )


def bent(body, modes):
    """A bend in the xz plane of unit mass norm; modes of a square section have no direction of their own."""
    field = np.zeros((len(body.nodes), body.dofs_per_node))
    field[:, 2] = body.nodes[:, 0] ** 2
    shape, *_ = np.linalg.lstsq(body.expansion.toarray(), field.ravel())
    weights = modes.T @ (body.mass @ shape)
    return modes @ (weights / np.linalg.norm(weights))


@pytest.mark.slow
def test_a_free_full_body_keeps_energy_and_momenta_at_order_two(arm, complete):
    bending = bent(arm.body, complete.vectors[:, :6])
    thrown = Placed(
        arm,
        velocity=[0.3, -0.2, 0.1],
        angular_velocity=[1.0, 1.5, 2.0],
        coordinate_rates=np.sqrt(MASS) * bending,
    )
    system = System((thrown,))

    def drifts(h):
        kept = balances(system, run(system, 0.1, h))
        assert np.ptp(kept.strain) > 0.01 * kept.total[0]
        return np.array(
            [
                np.abs(values - values[0]).max() / np.abs(values).max()
                for values in (kept.total, kept.momentum, kept.angular_momentum)
            ]
        )

    coarse, fine = drifts(1e-3), drifts(5e-4)
    assert (fine < 1e-5).all()
    np.testing.assert_allclose(np.log2(coarse / fine), 2.0, atol=0.1)


def shoulder():
    return Ball(first=GROUND, second=At("arm", "root"), name="shoulder")


@pytest.mark.slow
def test_a_swinging_full_body_keeps_its_energy_at_order_two(arm):
    system = System((Placed(arm),), (shoulder(),), gravity=GRAVITY)

    def drift(h):
        kept = balances(system, run(system, 0.2, h))
        return np.abs(kept.total - kept.total[0]).max() / np.ptp(kept.potential)

    coarse, fine = drift(2e-3), drift(1e-3)
    assert fine < 1e-5
    np.testing.assert_allclose(np.log2(coarse / fine), 2.0, atol=0.15)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::supple.errors.StartWarning")  # the lump is set in motion
def test_full_and_rigid_bodies_in_one_system(arm, complete):
    """A lump hinged to the arm's tip; at every output as with the arm in its complete basis."""
    lump = RigidBody("lump", 10.0, [0, 0, 0], 0.2 * np.eye(3), {"eye": [-0.2, 0, 0]})
    elbow = Revolute(first=At("arm", "tip"), second=At("lump", "eye"), axis=(0, 1, 0), name="elbow")

    def kept(body):
        swung = Placed(body, angular_velocity=[0.5, -1.0, 2.0])
        system = System((swung, Placed(lump, position=[1.2, 0, 0])), (shoulder(), elbow), gravity=GRAVITY)
        solution = run(system, 0.1, 2e-3)
        return balances(system, solution), joint_residuals(system, solution)

    (full, residuals), (reduced, same_residuals) = kept(arm), kept(project(soft_arm(), complete))
    assert_equal(full, reduced, rtol=1e-9)
    assert np.ptp(full.total) < 1e-3 * np.ptp(full.kinetic)
    np.testing.assert_allclose(residuals, same_residuals, atol=1e-10)
    assert np.abs(residuals).max() < 1e-10
