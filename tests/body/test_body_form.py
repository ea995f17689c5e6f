"""All forms of a body have the same members; where they describe the same motion, they agree."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from supple.body import (
    BodyForm,
    FlexibleBody,
    FullBody,
    MeanAxisFrame,
    NodalFixedFrame,
    RigidBody,
    RigidInterface,
    flexible_body,
    in_space,
)
from supple.errors import ModelError
from supple.fem import stress_recovery, von_mises
from supple.integrate import FloatingMotion
from supple.machine import Placed
from supple.quantities import von_mises_history
from supple.reduction import (
    CompleteBasis,
    NoDerivatives,
    ReducedBody,
    ReductionBasis,
    project,
    reduction_basis,
)

KINDS = ("rigid", "full", "reduced")
MASS = 2.0 * 0.4 * 0.02 * 2700.0
FRAME = NodalFixedFrame("root")
TIMES = 4


@pytest.fixture(scope="module")
def plate(shell) -> FlexibleBody:
    """The strip of 2 x 0.4 m with rigid ends, linear: its complete basis has no tensors."""
    ends = [RigidInterface("root", "root"), RigidInterface("tip", "tip")]
    return flexible_body("plate", shell, ends).linearized()


@pytest.fixture(scope="module")
def basis(plate) -> ReductionBasis:
    return reduction_basis(plate, FRAME, CompleteBasis(), derivatives=NoDerivatives())


@pytest.fixture(scope="module")
def forms(plate, basis) -> dict[str, BodyForm]:
    points = {interface.name: interface.position for interface in plate.interfaces}
    return {
        "rigid": RigidBody("plate", MASS, np.array([1.0, 0, 0]), np.diag([1.0, 10.0, 10.0]), points),
        "full": FullBody(plate, FRAME),
        "reduced": project(plate, basis),
    }


def moving(coordinates: np.ndarray) -> FloatingMotion:
    """Any motion of a floating frame with given coordinates (t, r)."""
    rng = np.random.default_rng(3)
    t, r = coordinates.shape
    return FloatingMotion(
        position=rng.normal(size=(t, 3)),
        rotation=Rotation.random(t, rng=rng).as_matrix(),
        coordinates=coordinates,
        velocity=rng.normal(size=(t, 3)),
        angular_velocity=rng.normal(size=(t, 3)),
        coordinate_rates=rng.normal(size=(t, r)),
        acceleration=rng.normal(size=(t, 3)),
        angular_acceleration=rng.normal(size=(t, 3)),
        coordinate_accelerations=rng.normal(size=(t, r)),
    )


def amounts(basis: ReductionBasis) -> np.ndarray:
    """Coordinates (t, r) of the complete basis that deform the strip by decimetres."""
    return 0.1 * np.random.default_rng(4).standard_normal((TIMES, basis.r))


@pytest.mark.parametrize("kind", KINDS)
def test_every_form_answers_every_question(forms, kind):
    body = forms[kind]
    r, n_nodes = body.n_coordinates, len(body.nodes)
    assert body.kind == kind
    assert body.name == "plate"
    assert body.mass == pytest.approx(MASS, rel=1e-10)
    assert body.nodes.shape == (n_nodes, 3)
    assert [interface.name for interface in body.interfaces] == ["root", "tip"]
    for interface in body.interfaces:
        assert interface.position.shape == (3,)
        assert interface.motion.shape == (6, r)
        assert body.interface(interface.name).name == interface.name
    assert body.expand(np.zeros((TIMES, r))).shape == (TIMES, n_nodes, 3)
    motion = moving(np.zeros((TIMES, r)))
    assert body.positions(motion).shape == (TIMES, n_nodes, 3)
    np.testing.assert_array_equal(body.positions(motion, [1, 0]), body.positions(motion)[:, [1, 0]])
    assert body.is_linear
    assert body.rotation_rows is None or body.rotation_rows.shape[1] == r
    assert body.rotation_limit > 0
    assert body.lowest_frequency() > 0


def test_forms_have_their_own_number_of_coordinates(forms, plate, basis):
    assert forms["rigid"].n_coordinates == 0
    assert forms["full"].n_coordinates == plate.n
    assert forms["reduced"].n_coordinates == basis.r == plate.n - 6


def test_a_complete_basis_deforms_as_the_full_body(forms, plate, basis):
    full, reduced = forms["full"], forms["reduced"]
    assert reduced.lowest_frequency() == pytest.approx(full.lowest_frequency(), rel=1e-6)
    assert reduced.rotation_limit == full.rotation_limit
    np.testing.assert_allclose(
        reduced.rotation_rows, full.rotation_rows @ basis.vectors, atol=1e-10 * abs(basis.vectors).max()
    )
    np.testing.assert_allclose(
        reduced.interface("tip").motion, plate.interface("tip").motion @ basis.vectors, rtol=1e-12
    )


def test_positions_are_the_frame_plus_the_turned_deformed_place(forms, plate, basis):
    """r = R + A (x + u), u the displacement part of T V gamma, written out node by node."""
    gamma = amounts(basis)
    motions = {"full": moving(gamma @ basis.vectors.T), "reduced": moving(gamma)}
    nodal = (plate.expansion @ (basis.vectors @ gamma.T)).T.reshape(TIMES, -1, 6)
    for kind, motion in motions.items():
        found = forms[kind].positions(motion)
        for t in range(TIMES):
            for a, x in enumerate(plate.nodes):
                expected = motion.position[t] + motion.rotation[t] @ (x + nodal[t, a, :3])
                np.testing.assert_allclose(found[t, a], expected, atol=1e-11)


def test_the_same_motion_takes_every_form_to_the_same_places(forms, basis):
    """The rigid form at its points, undeformed; the full and the reduced one at all nodes, deformed."""
    gamma = amounts(basis)
    deformed = [
        forms["full"].positions(moving(gamma @ basis.vectors.T)),
        forms["reduced"].positions(moving(gamma)),
    ]
    np.testing.assert_allclose(*deformed, atol=1e-11)
    still = {kind: moving(np.zeros((TIMES, body.n_coordinates))) for kind, body in forms.items()}
    rigid = forms["rigid"].positions(still["rigid"])
    for kind in ("full", "reduced"):
        nodes = forms[kind].nodes
        at_points = [int(np.argmin(np.linalg.norm(nodes - x, axis=1))) for x in forms["rigid"].nodes]
        np.testing.assert_allclose(nodes[at_points], forms["rigid"].nodes, atol=1e-14)
        np.testing.assert_allclose(forms[kind].positions(still[kind], at_points), rigid, atol=1e-13)


def test_points_of_a_rigid_body_move_with_its_angular_velocity(forms):
    """v = A (w x x) + V."""
    body = forms["rigid"]
    motion = moving(np.zeros((TIMES, 0)))
    turning = np.cross(motion.angular_velocity[:, None], body.nodes)
    expected = in_space(motion.velocity, motion.rotation, turning)
    np.testing.assert_allclose(body.node_motion(motion, [0, 1]).velocity, expected, atol=1e-13)


@pytest.mark.parametrize("kind", KINDS)
def test_an_unknown_interface_is_told_with_the_nearest(forms, kind):
    with pytest.raises(ModelError, match=r"body 'plate' has no interface 'tipp'; did you mean 'tip'\?"):
        forms[kind].interface("tipp")
    with pytest.raises(ModelError, match="body 'plate' has no interface 'hub'; there are: root, tip"):
        forms[kind].interface("hub")


@pytest.mark.parametrize("kind", KINDS)
def test_a_node_outside_the_body_is_refused(forms, kind):
    body = forms[kind]
    with pytest.raises(ModelError, match=f"node numbers 999 to 999; the body has {len(body.nodes)} nodes"):
        body.positions(moving(np.zeros((1, body.n_coordinates))), [999])


def test_a_linearised_body_keeps_its_elements_and_has_the_linear_stress(shell):
    nonlinear = flexible_body("plate", shell)
    linear = nonlinear.linearized()
    assert linear.is_linear
    assert not nonlinear.is_linear
    assert linear.model is nonlinear.model is shell
    q = 0.01 * np.random.default_rng(5).standard_normal(linear.n)
    K = linear.stiffness

    np.testing.assert_array_equal(linear.force.internal_force(q), K @ q)
    np.testing.assert_allclose(linear.force.energies(q[:, None]), [q @ K @ q / 2], rtol=1e-12)
    nonlinear_part = nonlinear.force.internal_force(q) - K @ q
    assert np.linalg.norm(nonlinear_part) > 1e-3 * np.linalg.norm(K @ q)
    tangent = nonlinear.force.tangent(np.zeros(linear.n))
    assert abs(tangent - K).max() < 1e-12 * abs(K).max()

    nodal = linear.expansion @ q
    expected = von_mises(stress_recovery(linear.model).linearized().at_nodes(nodal)).max(axis=1)
    found = von_mises_history(FullBody(linear, MeanAxisFrame()), linear.model, q[None])
    np.testing.assert_allclose(found[0], expected, rtol=1e-12)


def test_forms_are_known_by_their_kind(forms):
    """The word that a run's summary writes belongs to the type."""
    kinds = {RigidBody: "rigid", FullBody: "full", ReducedBody: "reduced"}
    assert {type(body): body.kind for body in forms.values()} == kinds


@pytest.mark.parametrize("kind", KINDS)
def test_the_centre_of_mass_moves_as_asked(forms, kind):
    """The plate lies from 0 to 2 along x; its mesh origin is at an end."""
    body = forms[kind]
    np.testing.assert_allclose(body.centre_of_mass, [1.0, 0.0, 0.0], atol=1e-9)
    turn = Rotation.from_rotvec([0.2, -0.4, 1.1])
    spin, wanted = np.array([0.3, 2.0, -5.0]), np.array([1.0, 2.0, 3.0])
    placed = Placed(body, rotation=turn.as_matrix(), angular_velocity=spin).with_centre_velocity(wanted)
    of_centre = placed.velocity + turn.apply(np.cross(spin, [1.0, 0.0, 0.0]))
    np.testing.assert_allclose(of_centre, wanted, atol=1e-8)
    still = Placed(body).with_centre_velocity(wanted)
    np.testing.assert_allclose(still.velocity, wanted)
    np.testing.assert_allclose(still.angular_velocity, 0.0)
    with pytest.raises(ModelError, match="centre velocity of body 'plate'"):
        Placed(body).with_centre_velocity([1.0, 2.0])
