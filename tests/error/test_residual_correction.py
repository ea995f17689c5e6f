"""Motion that a basis misses: nothing in a complete basis, the static response where nothing moves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from supple.algebra import constrained_factor
from supple.algebra.rotation import rotation_exp
from supple.body import (
    FullBody,
    MeanAxisFrame,
    NodalFixedFrame,
    RayleighDamping,
    RigidBody,
    RigidInterface,
    flexible_body,
)
from supple.error import missing_motion, residual_corrections
from supple.errors import ModelError
from supple.fem import Isotropic, solid_model
from supple.integrate import FixedStep, FloatingMotion, Run, Solution, Statistics, Tolerances
from supple.machine import (
    GROUND,
    At,
    Ball,
    DeadForce,
    Fixed,
    FollowerForce,
    Placed,
    Revolute,
    System,
)
from supple.mesh import CellType, block
from supple.reduction import (
    AttachmentModes,
    CompleteBasis,
    Condensation,
    CraigBampton,
    NoDerivatives,
    NormalModes,
    project,
    reduction_basis,
)
from supple.simulation import equilibrium, simulate

FRAMES = {"nodal-fixed": NodalFixedFrame("root"), "mean-axis": MeanAxisFrame()}
DAMPING = RayleighDamping(alpha=0.2, beta=2e-4)
LENGTH = 1.0
TIP = [0.0, 0.3, 0.5]


@pytest.fixture(scope="module")
def beam():
    """A soft solid beam along x, Green-Lagrange."""
    model = solid_model(block(LENGTH, 0.2, 0.2, 3, 1, 1, CellType.TETRA4), Isotropic(5e5, 0.3, 1000.0))
    return flexible_body("beam", model, (RigidInterface("root", "root"), RigidInterface("tip", "tip")))


def hanging(body):
    """The beam on a ball joint, a lump hinged to its tip; gravity, and forces of every kind."""
    lump = RigidBody("lump", 10.0, [0, 0, 0], 0.2 * np.eye(3), {"eye": [-0.2, 0, 0]})
    return System(
        bodies=(
            Placed(body, angular_velocity=[2.0, -4.0, 8.0]),
            Placed(lump, position=[LENGTH + 0.2, 0, 0]),
        ),
        joints=(
            Ball(first=GROUND, second=At("beam", "root"), name="shoulder"),
            Revolute(first=At("beam", "tip"), second=At("lump", "eye"), axis=(0, 1, 0), name="elbow"),
        ),
        loads=(
            DeadForce(body="beam", at=[7, 9], force=[0.0, 20.0, 5.0]),
            FollowerForce(first=At("beam", "tip"), force=[0.0, 0.0, 30.0]),
        ),
        gravity=(0, 0, -9.81),
    )


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::supple.errors.StartWarning")  # the joints take the lump along
@pytest.mark.parametrize("name", FRAMES)
def test_a_complete_basis_misses_nothing(beam, name):
    """Inertia, elasticity, damping, joints and loads of the full body balance along the run."""
    basis = reduction_basis(beam, FRAMES[name], CompleteBasis(), derivatives=NoDerivatives())
    system = hanging(project(beam, basis, damping=DAMPING))
    solution = simulate(
        system,
        Run(duration=0.2, output_step=0.02, step=FixedStep(0.01), tolerances=Tolerances(residual=1e-11)),
    )
    full = FullBody(beam, FRAMES[name], DAMPING)
    missed = residual_corrections(system, full, basis, solution, np.array([3, 10]))
    bent = np.linalg.norm(beam.expansion @ basis.vectors @ solution.bodies["beam"].coordinates[-1])
    assert bent > 0.05
    np.testing.assert_allclose(missed.times, [0.06, 0.2])
    assert np.linalg.norm(beam.expansion @ missed.deformation[:, -1]) < 1e-8 * bent
    assert missed.rms[-1] < 1e-8 * bent


def at_rest(system, r):
    """One instant of a system of one body that rests undeformed, its joints without force."""
    zero, none = np.zeros((1, 3)), np.zeros((1, r))
    motion = FloatingMotion(zero, np.eye(3)[None], none, zero, zero, none, zero, zero, none)
    forces = {joint.name: np.zeros((1, 6)) for joint in system.joints}
    multipliers = {joint.name: np.zeros((1, joint.n_constraints)) for joint in system.joints}
    return Solution(np.zeros(1), {"beam": motion}, forces, Statistics(), multipliers=multipliers)


def held_deflection(body, held, load):
    """Static deflection of the nodes (N, 3) with interfaces held."""
    rows = np.vstack([body.interface(name).motion.toarray() for name in held])
    q = constrained_factor(body.stiffness, rows, body.rigid_modes).solve(load)
    return (body.expansion @ q).reshape(-1, 3)


def tip_load(body):
    return body.interface("tip").motion[:3].T @ np.array(TIP)


def in_space(full, missed):
    """Displacement of the nodes by the missing motion, frame included, of a body at rest, (N, 3)."""
    return full.expand(missed.deformation[:, 0]) + missed.origin[0] + np.cross(missed.rotation[0], full.nodes)


@pytest.mark.slow
@pytest.mark.parametrize("name", FRAMES)
def test_a_large_missing_motion_is_the_full_equilibrium(beam, name):
    """A body that should bend by a quarter of its length: one Newton step would be far off."""
    basis = reduction_basis(beam, FRAMES[name], CraigBampton(n_modes=4), derivatives=NoDerivatives())
    full = FullBody(beam, FRAMES[name])
    force = np.array([0.0, 0.0, 300.0])

    def held(body):
        return System(
            bodies=(Placed(body),),
            joints=(Fixed(first=GROUND, second=At("beam", "root"), name="wall"),),
            loads=(DeadForce(body="beam", at="tip", force=force),),
        )

    reduced = project(beam, basis)
    system = held(reduced)
    missed = residual_corrections(system, full, basis, at_rest(system, basis.r), np.array([0]))
    rest = equilibrium(held(full)).system.bodies[0]

    def moved(origin, rotation, coordinates):
        return origin + (full.nodes + full.expand(coordinates)) @ rotation.T - full.nodes

    expected = moved(rest.position, rest.rotation, rest.coordinates)
    turn = np.asarray(rotation_exp(missed.rotation[0]))
    found = moved(missed.origin[0], turn, missed.deformation[:, 0])
    size = np.abs(expected).max()
    assert size > LENGTH / 5
    clamped = NormalModes(1).build(beam, NodalFixedFrame("root")).frequencies[0]
    inertia = (reduced.frequencies[0] / clamped / 100) ** 2  # M / p, as below
    np.testing.assert_allclose(found, expected, atol=(2e-3 + inertia) * size)
    linear = held_deflection(beam, ["root"], beam.interface("tip").motion[:3].T @ force)
    assert np.abs(linear - expected).max() > 0.05 * size


def test_where_no_equilibrium_is_found_that_is_said(beam, monkeypatch):
    monkeypatch.setattr(missing_motion, "MOST_CORRECTIONS", 0)
    monkeypatch.setattr(missing_motion, "MOST_RELAXATIONS", 0)
    basis = reduction_basis(beam, FRAMES["nodal-fixed"], CraigBampton(n_modes=4), derivatives=NoDerivatives())
    system = System(
        bodies=(Placed(project(beam, basis)),),
        joints=(Fixed(first=GROUND, second=At("beam", "root"), name="wall"),),
        loads=(DeadForce(body="beam", at="tip", force=TIP),),
    )
    full = FullBody(beam, FRAMES["nodal-fixed"])
    missed = residual_corrections(system, full, basis, at_rest(system, basis.r), np.array([0]))
    assert np.isinf(missed.rms).all()
    assert not missed.deformation.any()


@pytest.mark.parametrize("name", FRAMES)
def test_from_rest_it_is_the_static_deflection_with_the_joint_held(beam, name):
    """In either frame the body hangs on its root; the inertia that steadies free bodies adds little.

    M / p with 1 / p = (omega_1 / 100)^2, omega_1 that of the basis in its frame, lowers the deflection
    by about 1 / (p omega_c^2), omega_c the lowest frequency of the beam held at its root. The load is too
    small for the beam to shorten as it bends.
    """
    force = 0.01 * np.array(TIP)
    basis = reduction_basis(beam, FRAMES[name], CraigBampton(n_modes=4), derivatives=NoDerivatives())
    reduced = project(beam, basis)
    system = System(
        bodies=(Placed(reduced),),
        joints=(Fixed(first=GROUND, second=At("beam", "root"), name="wall"),),
        loads=(DeadForce(body="beam", at="tip", force=force),),
    )
    full = FullBody(beam, FRAMES[name])
    missed = residual_corrections(system, full, basis, at_rest(system, basis.r), np.array([0]))
    expected = held_deflection(beam, ["root"], 0.01 * tip_load(beam))
    size = np.abs(expected).max()
    clamped = NormalModes(1).build(beam, NodalFixedFrame("root")).frequencies[0]
    bound = (reduced.frequencies[0] / clamped / 100) ** 2
    np.testing.assert_allclose(in_space(full, missed), expected, atol=1.2 * bound * size)
    np.testing.assert_allclose(missed.rms, np.sqrt(np.mean(np.sum(expected**2, axis=1))), rtol=1.2 * bound)
    D = FRAMES[name].constraint(beam)
    assert np.abs(D @ missed.deformation).max() < 1e-9 * np.abs(D).max() * size


@pytest.mark.slow
@pytest.mark.parametrize("name", FRAMES)
def test_a_closed_loop_stays_closed(beam, name):
    """Held at both ends, where the joint forces are not known from balance alone; redundant rows included."""
    basis = reduction_basis(beam, FRAMES[name], CraigBampton(n_modes=4), derivatives=NoDerivatives())
    middle = int(np.argmin(np.linalg.norm(beam.nodes - beam.nodes.mean(axis=0), axis=1)))
    system = System(
        bodies=(Placed(project(beam, basis)),),
        joints=(
            Fixed(first=GROUND, second=At("beam", "root"), name="left"),
            Fixed(first=GROUND, second=At("beam", "tip"), name="right"),
        ),
        loads=(DeadForce(body="beam", at=[middle], force=TIP),),
    )
    full = FullBody(beam, FRAMES[name])
    missed = residual_corrections(system, full, basis, at_rest(system, basis.r), np.array([0]))
    load = np.zeros((len(beam.nodes), 3))
    load[middle] = TIP
    expected = held_deflection(beam, ["root", "tip"], beam.expansion.T @ load.ravel())
    np.testing.assert_allclose(in_space(full, missed), expected, atol=1e-3 * np.abs(expected).max())


@pytest.mark.parametrize("name", FRAMES)
def test_a_free_body_is_judged_by_its_deformation_alone(beam, name):
    """Inertia relief: the deformation under a load that the body's own acceleration balances."""
    recipe = AttachmentModes(NormalModes(4))
    basis = reduction_basis(beam, FRAMES[name], recipe, derivatives=NoDerivatives())
    system = System((Placed(project(beam, basis)),), loads=(DeadForce(body="beam", at="tip", force=TIP),))
    load, R = tip_load(beam), beam.rigid_modes
    rigid = np.linalg.solve(R.T @ (beam.mass @ R), R.T @ load)
    solution = at_rest(system, basis.r)
    # The rigid acceleration of the undeformed beam, about the mesh's origin, in which its frame rests too.
    motion = replace(
        solution.bodies["beam"], acceleration=rigid[None, :3], angular_acceleration=rigid[None, 3:]
    )
    solution = replace(solution, bodies={"beam": motion})
    missed = residual_corrections(system, FullBody(beam, FRAMES[name]), basis, solution, np.array([0]))
    relief = constrained_factor(beam.stiffness, (beam.mass @ R).T, R).solve(load - beam.mass @ R @ rigid)
    expected = (beam.expansion @ relief).reshape(-1, 3)
    np.testing.assert_allclose(missed.rms, np.sqrt(np.mean(np.sum(expected**2, axis=1))), rtol=1e-3)


def test_refuses_another_basis_than_the_runs(beam):
    frame = FRAMES["mean-axis"]
    basis, other = (reduction_basis(beam, frame, NormalModes(n), derivatives=NoDerivatives()) for n in (3, 4))
    system = System((Placed(project(beam, basis)),))
    with pytest.raises(ModelError, match="reduced to 4 coordinates"):
        residual_corrections(system, FullBody(beam, frame), other, at_rest(system, 3), np.array([0]))


def test_refuses_an_unknown_body(beam):
    frame = FRAMES["mean-axis"]
    basis = reduction_basis(beam, frame, NormalModes(3), derivatives=NoDerivatives())
    system = System((Placed(replace(project(beam, basis), name="boom")),))
    with pytest.raises(ModelError, match="residual correction: there is no body 'beam'"):
        residual_corrections(system, FullBody(beam, frame), basis, at_rest(system, 3), np.array([0]))


def test_the_motion_that_condensed_tensors_let_follow_is_known(beam):
    """A static answer whose displacements contain z: beside it little is missed, and no false tension."""
    frame = FRAMES["nodal-fixed"]
    basis = reduction_basis(beam, frame, CraigBampton(n_modes=3), derivatives=NoDerivatives())
    reduced = project(beam, basis)
    force = basis.vectors.T @ (100 * tip_load(beam))
    gamma = np.zeros(basis.r)
    for share in np.linspace(0, 1, 11)[1:]:
        for _ in range(20):
            gamma += np.linalg.solve(
                reduced.tensors.tangent(gamma), share * force - reduced.tensors.internal_force(gamma)
            )
    system = System(
        bodies=(Placed(reduced),),
        joints=(Fixed(first=GROUND, second=At("beam", "root"), name="wall"),),
        loads=(DeadForce(body="beam", at="tip", force=[100 * f for f in TIP]),),
    )
    still = at_rest(system, basis.r)
    motion = replace(still.bodies["beam"], coordinates=gamma[None])
    solution = replace(still, bodies={"beam": motion})
    missed = residual_corrections(system, FullBody(beam, frame), basis, solution, np.array([0]))
    z = Condensation(beam, basis).bilinear(gamma[None], gamma[None])[:, 0]
    assert np.linalg.norm(z) > 1e-3 * np.linalg.norm(basis.vectors @ gamma)
    left = missed.deformation[:, 0]
    assert np.linalg.norm(left) < 0.5 * np.linalg.norm(z + left)
