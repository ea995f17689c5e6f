"""The study of tolerances: its measures on made-up motions, and the pendulum from end to end."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from supple.integrate import Solution
from supple_benchmarks.machines.report import errors, ordered_share, report
from supple_benchmarks.machines.run import (
    Drift,
    MachineRun,
    PointHistory,
    Variant,
    energy_norm,
    equivalent_strain,
)
from supple_benchmarks.machines.study import Separation, Study, run_study

TIMES = np.linspace(0.0, 1.0, 11)


def history(offset):
    """A point whose every quantity is off by `offset` (t,) in one component."""
    vector = np.ones((11, 3))
    vector[:, 0] += offset
    return PointHistory(TIMES, vector, vector, vector, 5 + offset, 1e-6 * (5 + offset))


def made_up(variant, tolerance, offset):
    nothing = Solution(TIMES, {}, {}, None)
    error = abs(offset) * TIMES
    return MachineRun(
        variant, tolerance, 10, None, None, nothing, history(offset * TIMES), error, Drift(0.0, 0.0)
    )


@pytest.fixture
def study(pendulum):
    runs = (made_up(Variant.WHOLE_BASIS, 0.1, 0.3), made_up(Variant.WHOLE_BASIS, 0.01, -0.02))
    return Study(pendulum, made_up(Variant.UNREDUCED, None, 0.0), runs)


def test_errors_are_the_largest_and_the_rms_distance(study):
    found = errors(study, study.runs[0], study.reference)
    assert found["position"]["max"] == pytest.approx(0.3)
    assert found["stress"]["rms"] == pytest.approx(0.3 * np.sqrt(np.mean(TIMES**2)))
    assert found["stress"]["max_over_largest"] == pytest.approx(0.3 / 5)


def test_motions_are_compared_until_two_runs_of_one_body_part(study):
    assert study.compared_until == 1.0
    parted = Separation("h", "h/2", TIMES, 0.1 * TIMES, 0.5, (None, None))
    never = Separation("a", "b", TIMES, 0 * TIMES, None, (None, None))
    study = replace(study, separations=(never, parted))
    assert study.compared_until == 0.5
    assert errors(study, study.runs[0], study.reference)["position"]["max"] == pytest.approx(0.15)


def test_errors_of_the_deformation_are_relative_to_its_norm(study):
    reference = replace(study.reference, deformation_error=4.0 * TIMES)
    found = errors(replace(study, reference=reference), study.runs[0], reference)
    assert found["deformation"]["max"] == pytest.approx(0.3)
    assert found["deformation"]["max_over_largest"] == pytest.approx(0.075)
    # Against another reduced run nothing is known of it.
    assert "deformation" not in errors(study, study.runs[0], study.runs[1])


def test_the_energy_norm_is_the_root_of_twice_the_strain_energy(pendulum):
    """Of a stretched cylinder: E eps^2 V."""
    strain, poisson = np.array([0.0, 1e-3, -2e-3]), pendulum.material.poissons_ratio
    x = pendulum.model.mesh.nodes
    stretched = (x * [1.0, -poisson, -poisson]).reshape(-1, 1) * strain
    mass = pendulum.body.rigid_modes[:, 0] @ (pendulum.body.mass @ pendulum.body.rigid_modes[:, 0])
    volume = mass / pendulum.material.density
    expected = np.sqrt(pendulum.material.youngs_modulus * strain**2 * volume)
    np.testing.assert_allclose(energy_norm(pendulum, stretched), expected, rtol=1e-9, atol=1e-12)


def test_equivalent_strain_of_uniaxial_stress_is_that_of_the_strains(pendulum):
    """sqrt(2/3 e:e) of the deviator of (1, -nu, -nu) s/E."""
    nu, E = pendulum.material.poissons_ratio, pendulum.material.youngs_modulus
    axial = np.array([1.0, -nu, -nu]) / E
    deviator = axial - axial.mean()
    expected = np.sqrt(2 / 3 * deviator @ deviator)
    assert equivalent_strain(pendulum.material, np.array([1.0]))[0] == pytest.approx(expected)


def test_smaller_errors_of_smaller_tolerances_are_counted_over_the_outputs(study):
    study = replace(study, machine=replace(study.machine, compared_from=0.0))
    loose, tight = 0.3 * TIMES, 0.02 * TIMES
    assert ordered_share(study, [loose, tight]) == 1.0
    # A third error that is larger than the second from half time on.
    late = np.where(TIMES > 0.45, 1.0, 0.0)
    assert ordered_share(study, [loose, tight, late]) == 0.4
    # Counted from 0.35 s on: one of seven outputs is still in order.
    compared_from = replace(study, machine=replace(study.machine, compared_from=0.35))
    assert ordered_share(compared_from, [loose, tight, late]) == pytest.approx(1 / 7)


@pytest.mark.slow
def test_whole_bases_converge_to_the_unreduced_pendulum_and_cut_ones_to_the_exact_modes(pendulum, tmp_path):
    messages = []

    def announce(label):
        messages.append(label)
        return lambda fraction: None

    for study in run_study(pendulum, tmp_path, announce, (0.1, 0.01)):
        numbers = report(study)
    loose, tight = numbers["whole_bases"]
    for quantity in ("velocity", "acceleration", "stress", "strain"):
        assert tight["errors"][quantity]["max"] < 0.5 * loose["errors"][quantity]["max"]
    assert tight["errors"]["stress"]["max_over_largest"] < 1e-2
    loose, tight = numbers["tolerances"]
    assert loose["coordinates"] == tight["coordinates"] == pendulum.n_modes
    assert tight["modes"] > loose["modes"]
    assert tight["largest_eigenvalue_error"] < 0.01
    exact = "errors_against_exact_modes"
    assert tight[exact]["stress"]["max"] < loose[exact]["stress"]["max"]
    # Forces at the hinge are what the vibrations left out answer to.
    for cut, attached in zip(numbers["tolerances"], numbers["with_attachment_modes"], strict=True):
        assert attached["coordinates"] == cut["coordinates"] + 6
        assert attached["errors"]["position"]["max"] < 1e-2 * cut["errors"]["position"]["max"]
    drifts = [numbers["unreduced"], *numbers["whole_bases"]]
    assert max(abs(row["energy_drift"]) for row in drifts) < 1e-3
    assert max(row["joint_drift"] for row in numbers["tolerances"]) < 1e-9
    # In the energy norm, at every output.
    assert numbers["smaller_e_smaller_error"]["share_of_outputs"]["whole_bases"]["deformation"] == 1.0
    for variant in ("whole_bases", "with_attachment_modes"):
        loose, tight = (row["errors"]["deformation"]["max"] for row in numbers[variant])
        assert tight < 0.8 * loose
    # A second study finds every body and motion on disk: nothing is reduced or simulated again.
    stored = {path: path.stat().st_mtime_ns for path in tmp_path.glob("*.h5")}
    again = list(run_study(pendulum, tmp_path, announce, (0.1, 0.01)))[-1]
    assert {path: path.stat().st_mtime_ns for path in tmp_path.glob("*.h5")} == stored
    for one, other in zip((again.reference, *again.runs), (study.reference, *study.runs), strict=True):
        np.testing.assert_array_equal(one.point.stress, other.point.stress)
