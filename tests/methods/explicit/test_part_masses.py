"""Concentrated masses at nodes of explicit parts; what else stands beside elements is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from fixtures.explicit_bars import SOFT, bar, stepped
from scipy import sparse

from supple.errors import ModelError
from supple.fem import (
    Attached,
    FiniteElementModel,
    HomogeneousSection,
    Isotropic,
    RigidPiece,
    linear_strains,
    lumped_mass,
    shell_model,
)
from supple.integrate import Run
from supple.machine import At, DeadForce, Support, System
from supple.mesh import CellType, strip
from supple.methods.explicit import BulkViscosity, explicit_shell, explicit_subdomain
from supple.methods.explicit.materials import StVenantKirchhoff
from supple.simulation import simulate


def with_mass(model: FiniteElementModel, node: int, *diagonal: float) -> FiniteElementModel:
    d = model.dofs_per_node
    values = np.zeros(model.n_dofs)
    values[node * d : node * d + len(diagonal)] = diagonal
    return replace(model, attached=Attached(mass=sparse.csc_array(sparse.diags_array(values))))


def test_a_mass_at_a_node_is_in_the_lumped_mass_whatever_the_density_of_the_law():
    model = bar(CellType.HEXA8)
    heavier = StVenantKirchhoff(Isotropic(SOFT.youngs_modulus, SOFT.poissons_ratio, 3 * SOFT.density))
    plain = explicit_subdomain(model, heavier)
    loaded = explicit_subdomain(with_mass(model, 5, 0.7, 0.7, 0.7), heavier)
    np.testing.assert_allclose(
        loaded.masses - plain.masses, 0.7 * (np.arange(model.mesh.n_nodes) == 5), atol=1e-12
    )
    assert lumped_mass(loaded.model).reshape(-1, 3)[5] == pytest.approx(
        lumped_mass(model).reshape(-1, 3)[5] + 0.7
    )


@pytest.mark.slow
def test_a_heavy_end_on_a_light_bar_swings_as_one_mass_on_a_spring():
    """Rayleigh's quotient, omega^2 = (E A / L) / (M + m / 3), where the bar has 4 % of the mass M; nu = 0."""
    light = Isotropic(100.0, 0.0, 1.0)
    model = bar(CellType.HEXA8, material=light)
    tip = model.mesh.node_sets["tip"]
    values = np.zeros((model.mesh.n_nodes, 3))
    values[tip] = 25.0
    beside = Attached(mass=sparse.csc_array(sparse.diags_array(values.ravel())))
    part = explicit_subdomain(
        replace(model, attached=beside), name="bar", bulk_viscosity=BulkViscosity(0.0, 0.0)
    )
    omega = np.sqrt(100.0 / 4.0 / (100.0 + 4.0 / 3.0))
    system = System(
        [part],
        supports=[Support(At("bar", "root"))],
        loads=[DeadForce(at="bar.tip", force=(0.02, 0.0, 0.0))],
    )
    period = 2 * np.pi / omega
    solution = simulate(system, stepped(Run(period, period / 40)))
    motion = solution.bodies["bar"]
    moved = (motion.nodes[:, tip, 0] - model.mesh.nodes[tip, 0]).mean(axis=1)
    exact = 0.02 / 25.0 * (1 - np.cos(omega * solution.times))
    np.testing.assert_allclose(moved, exact, atol=2e-3 * exact.max())


def test_other_things_beside_elements_are_refused():
    model = bar(CellType.HEXA8)
    nodes = np.array([0, 1])
    spring = linear_strains([(np.array([0, 3]), np.array([[1.0, -1.0]]), np.array([2.0]))], 3)
    for beside, what in (
        (Attached(springs=spring), "springs"),
        (Attached(damping=sparse.csc_array(np.eye(model.n_dofs))), "dashpots"),
        (Attached(rigid=(RigidPiece("rbe2_1", nodes, np.zeros(3)),)), "rigid ties"),
    ):
        with pytest.raises(ModelError, match=f"sub-domain 'explicit' supports no {what} beside its elements"):
            explicit_subdomain(replace(model, attached=beside))
    for unlike in ((1.0, 1.0, 2.0), (1.0, 1.0, 0.0)):
        with pytest.raises(
            ModelError, match=r"mass at node 5 \(one of 1\) has rotary inertia, a centre beside"
        ):
            explicit_subdomain(with_mass(model, 5, *unlike))
    coupled = np.zeros((model.n_dofs, model.n_dofs))
    coupled[np.ix_([0, 3], [0, 3])] = [[1.0, -1.0], [-1.0, 1.0]]
    with pytest.raises(ModelError, match="2 terms of concentrated masses act between nodes"):
        explicit_subdomain(replace(model, attached=Attached(mass=sparse.csc_array(coupled))))


def test_a_mass_on_a_shell_has_no_inertia():
    model = shell_model(strip(1.0, 0.1, 4, 2), HomogeneousSection(Isotropic(2.1e11, 0.3, 7800.0), 5e-3))
    loaded = explicit_shell(with_mass(model, 3, 0.5, 0.5, 0.5))
    assert loaded.mass == pytest.approx(1.0 * 0.1 * 5e-3 * 7800.0 + 0.5, rel=1e-12)
    with pytest.raises(ModelError, match=r"mass at node 3 .* has rotary inertia"):
        explicit_shell(with_mass(model, 3, 0.5, 0.5, 0.5, 1e-3, 1e-3, 1e-3))
