"""Split bodies: the parts together are the whole, and the joints hold them."""

from __future__ import annotations

import numpy as np
import pytest

from supple.algebra import lowest_modes
from supple.body import (
    AveragingInterface,
    MeanAxisFrame,
    RigidInterface,
    flexible_body,
    rigid_mass_properties,
)
from supple.errors import ModelError, SuppleWarning
from supple.fem import VON_KARMAN, HomogeneousSection, Isotropic, parts_of_model, shell_model, solid_model
from supple.integrate import FixedStep, Run
from supple.machine import GROUND, At, DeadForce, Fixed, Placed, Scaled, Sine, System, split_body
from supple.machine.split_body import frequency_changes
from supple.mesh import AlongAxis, ByCellSets, CellType, Mesh, block, divided, strip
from supple.reduction import NoDerivatives, NoLoads, Rubin, reduce
from supple.simulation import simulate

STEEL = Isotropic(2.1e11, 0.3, 7850.0)
STRIP = strip(length=1.0, width=0.1, n_length=12, n_width=2)
BLOCK = block(length=2.0, width=0.2, height=0.2, n_length=6, n_width=2, n_height=2, cell_type=CellType.HEXA8)


@pytest.mark.parametrize(
    "model",
    [
        shell_model(STRIP, HomogeneousSection(STEEL, 5e-3)),
        shell_model(STRIP, HomogeneousSection(STEEL, 5e-3), kinematics=VON_KARMAN),
        solid_model(BLOCK, STEEL),
    ],
    ids=["shell", "von-karman", "solid"],
)
def test_the_parts_on_their_shared_nodes_are_the_whole(model):
    mesh = divided(model.mesh, AlongAxis(3))
    n = model.dofs_per_node
    whole = {"stiffness": 0 * model.stiffness.toarray(), "mass": 0 * model.mass.toarray()}
    for part, own in zip(mesh.parts, parts_of_model(model, mesh), strict=True):
        assert own.kinematics is model.kinematics
        dofs = (part.nodes[:, None] * n + np.arange(n)).ravel()
        for name, matrix in whole.items():
            matrix[np.ix_(dofs, dofs)] += getattr(own, name).toarray()
    for name, matrix in whole.items():
        expected = getattr(model, name).toarray()
        assert abs(matrix - expected).max() <= 1e-12 * abs(expected).max()


def test_parts_have_the_mass_of_the_whole_and_keep_its_interfaces():
    split = split_body(
        "arm",
        shell_model(STRIP, HomogeneousSection(STEEL, 5e-3)),
        AlongAxis(2),
        (RigidInterface("root", "root"), AveragingInterface("tip", "tip")),
    )
    assert [part.name for part in split.parts] == ["arm-1", "arm-2"]
    masses = [rigid_mass_properties(p.nodal_mass, p.nodes, p.dofs_per_node).mass for p in split.parts]
    assert sum(masses) == pytest.approx(1.0 * 0.1 * 5e-3 * 7850.0, rel=1e-12)
    assert [[each.name for each in part.interfaces] for part in split.parts] == [
        ["root", "cut-1"],
        ["tip", "cut-1"],
    ]
    (joint,) = split.joints
    assert (joint.first, joint.second) == (At("arm-1", "cut-1"), At("arm-2", "cut-1"))
    assert joint.name == "arm cut-1"


def test_an_interface_across_a_cut_is_refused():
    model = shell_model(STRIP, HomogeneousSection(STEEL, 5e-3))
    with pytest.raises(ModelError, match=r"interface 'axis': its nodes are in several of the 2 parts"):
        split_body("arm", model, AlongAxis(2), (RigidInterface("axis", "axis"),))


@pytest.mark.slow
def test_a_split_cantilever_vibrates_as_the_whole_one_where_both_are_right():
    """Small deflections: the tip answers a harmonic force between its first two frequencies alike.

    Without lateral contraction, which rigid sections would hinder.
    """
    model = shell_model(STRIP, HomogeneousSection(Isotropic(2.1e11, 0.0, 7850.0), 5e-3))
    interfaces = (RigidInterface("root", "root"), RigidInterface("tip", "tip"))
    split = split_body("arm", model, AlongAxis(3), interfaces)
    run = Run(0.3, output_step=3e-3, step=FixedStep(3e-4))

    def tip(parts, joints=()):
        bodies = [
            Placed(
                reduce(
                    part.linearized(), MeanAxisFrame(), Rubin(12), derivatives=NoDerivatives(), loads=NoLoads
                )
            )
            for part in parts
        ]
        last = parts[-1].name
        clamp = Fixed(first=GROUND, second=At(parts[0].name, "root"))
        force = DeadForce(body=last, at="tip", force=Scaled((0.0, 0.0, 0.1), Sine(1.0, 12.0)))
        system = System(bodies, (clamp, *joints), (force,))
        motion = simulate(system, run).bodies[last]
        body = system.bodies[-1].body
        return body.positions(motion, np.flatnonzero(body.nodes[:, 0] > 0.999))[..., 2].mean(axis=1)

    whole = tip([flexible_body("arm", model, interfaces)])
    assert abs(tip(split.parts, split.joints) - whole).max() <= 2e-3 * abs(whole).max()


@pytest.mark.parametrize(("rows", "parts"), [(5, 2), (9, 2), (9, 4), (8, 3)])
def test_a_split_strip_has_the_frequencies_of_the_whole(rows, parts):
    """Cut through the middle row, five rows bent 32 % too stiffly."""
    model = shell_model(strip(1.0, 0.1, rows, 2), HomogeneousSection(Isotropic(2.1e11, 0.0, 7850.0), 5e-3))
    changes = frequency_changes(flexible_body("arm", model), split_body("arm", model, AlongAxis(parts)))
    assert abs(changes).max() < 5e-3


def test_other_frequencies_than_those_of_the_whole_are_warned_of():
    """Parts by cell sets may zigzag: here one triangle of a row is on the other side."""
    mesh = strip(1.0, 0.1, 6, 2)
    kind = next(iter(mesh.cells))
    low = mesh.nodes[mesh.cells[kind]][..., 0].mean(axis=1) < 0.5 + 1 / 12
    sets = {"A": {kind: np.flatnonzero(low)}, "B": {kind: np.flatnonzero(~low)}}
    mesh = Mesh(mesh.nodes, mesh.cells, mesh.node_sets, sets)
    model = shell_model(mesh, HomogeneousSection(Isotropic(2.1e11, 0.0, 7850.0), 5e-3))
    with pytest.warns(SuppleWarning, match=r"'arm': the ties of its 2 parts .* frequencies by \+[0-9.]+"):
        split_body("arm", model, ByCellSets(("A", "B")))


def test_tied_parts_tell_what_their_sections_change():
    """Without lateral contraction a strip bends as before; with it, rigid sections stiffen the strip."""
    interfaces = (RigidInterface("root", "root"),)

    def ratios(poisson, tie):
        model = shell_model(STRIP, HomogeneousSection(Isotropic(2.1e11, poisson, 7850.0), 5e-3))
        body = flexible_body("arm", model, interfaces)
        free = np.linalg.qr(body.mass @ body.rigid_modes)[0].T
        whole = np.sqrt(lowest_modes(body.stiffness, body.mass, 1, constraint=free).values)
        return split_body("arm", model, AlongAxis(2), interfaces, tie=tie).frequencies(1) / whole

    assert abs(ratios(0.0, RigidInterface) - 1) < 2e-3
    assert 2e-3 < ratios(0.3, RigidInterface) - 1 < 2e-2
    assert -2e-2 < ratios(0.3, AveragingInterface) - 1 < 0.0
