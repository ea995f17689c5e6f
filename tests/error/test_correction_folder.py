"""Rounds of a self-correction on disk: kept as they come, read instead of run, continued where cut off."""

from __future__ import annotations

import numpy as np
import pytest
from fixtures.runs_on_disk import RUNS, pendulum

from supple.body import FullBody, NodalFixedFrame, RigidInterface, flexible_body
from supple.error import CorrectionFolder, ReductionStart, SelfCorrection, self_correct
from supple.error.round_archive import RoundBases
from supple.errors import ResultFileError
from supple.fem import HomogeneousSection, Isotropic, shell_model
from supple.integrate import FixedStep, Run, Tolerances
from supple.machine import GROUND, At, Placed, PrescribedRotation, System
from supple.mesh import strip
from supple.reduction import CompressedDerivatives, CraigBampton, padded
from supple.simulation.watched_run import watched_run
from supple.storage import read_header, read_solution

CASE = "a strip that is turned"
RUN = Run(
    duration=1.0,
    output_step=0.02,
    step=FixedStep(0.02, smallest=1e-3),
    tolerances=Tolerances(residual=1e-9),
)
START = ReductionStart(
    SelfCorrection(absolute=1e-7, instants=10), CraigBampton(n_modes=3), CompressedDerivatives(3)
)


@pytest.fixture(scope="module")
def system():
    wall = HomogeneousSection(Isotropic(1e9, 0.3, 1000.0), 0.01)
    body = flexible_body("beam", shell_model(strip(1.0, 0.1, 4, 2), wall), (RigidInterface("root", "root"),))
    hinge = PrescribedRotation(
        name="hinge",
        first=GROUND,
        second=At("beam", "root"),
        axis=(0, -1, 0),
        angle=lambda time: 0.8 * time**3,
    )
    return System((Placed(FullBody(body, NodalFixedFrame("root"))),), (hinge,))


@pytest.fixture(scope="module")
def kept(system, tmp_path_factory):
    """A self-correction that ran to its end, and its folder."""
    folder = tmp_path_factory.mktemp("rounds")
    result = self_correct(system, RUN, {"beam": START}, archive=CorrectionFolder.create(folder, case=CASE))
    return result.bodies["beam"], folder


@pytest.mark.slow
def test_every_round_is_on_disk(kept):
    result, folder = kept
    archive = CorrectionFolder.resume(folder, case=CASE)
    assert len(result.rounds) == 2
    for number, solution in enumerate(each.solution for each in result.rounds):
        assert read_header(archive.motion(number)).complete
        written = read_solution(archive.motion(number)).bodies["beam"].coordinates
        np.testing.assert_array_equal(written, solution.bodies["beam"].coordinates)


@pytest.fixture
def simulated(monkeypatch):
    """Sizes of the runs that are simulated."""
    sizes = []

    def counting(system, run, **options):
        sizes.append(system.bodies[0].body.r)
        return watched_run(system, run, **options)

    monkeypatch.setattr("supple.simulation.recorded_run.watched_run", counting)
    return sizes


def repeated(system, folder):
    archive = CorrectionFolder.resume(folder, case=CASE)
    return self_correct(system, RUN, {"beam": START}, archive=archive).bodies["beam"]


@pytest.mark.slow
def test_a_finished_correction_is_read_and_not_run(system, kept, simulated, monkeypatch):
    """The same rounds, without one step, residual or eigenvalue."""
    result, folder = kept
    monkeypatch.delattr("supple.error.error_estimate.ErrorEstimator.assess")
    for what in ("reduction_basis", "enrich"):
        monkeypatch.delattr(f"supple.error.system_correction.{what}")
    again = repeated(system, folder)
    assert simulated == []
    for old, new in zip(result.rounds, again.rounds, strict=True):
        assert new.estimated_error == pytest.approx(old.estimated_error, rel=1e-9)
        assert new.indicator == old.indicator
        assert new.seconds == old.seconds
        np.testing.assert_array_equal(new.singular_values, old.singular_values)
        assert new.body.report.linear == old.body.report.linear
        assert new.body.report.corrections == old.body.report.corrections


@pytest.mark.slow
def test_a_correction_that_was_killed_goes_on_with_the_run_that_was_cut_off(
    system, kept, simulated, tmp_path
):
    """Killed in the second run: the first is read, the second goes on, and a third confirms it."""
    result, folder = kept
    archive = CorrectionFolder.create(tmp_path, case=CASE)
    for name in ("round-0.h5", "round-0.npz", "round-1.npz"):
        (tmp_path / name).write_bytes((folder / name).read_bytes())

    class KilledError(Exception):
        pass

    def stop(fraction):
        if fraction >= 0.5:
            raise KilledError

    with pytest.raises(KilledError):
        archive.simulate(1, with_body(system, padded(result.body)), RUN, progress=stop)
    assert not read_header(archive.motion(1)).complete
    assert 0.5 <= read_solution(archive.motion(1)).times[-1] < RUN.times[-1]
    simulated.clear()
    again = repeated(system, tmp_path)
    assert simulated == [result.body.r, result.next_basis.r]
    assert again.estimated_error == pytest.approx(result.estimated_error, rel=1e-12)
    whole = read_solution(folder / "round-1.h5")
    for name, array in read_solution(archive.motion(1)).bodies["beam"].arrays().items():
        np.testing.assert_array_equal(array, whole.bodies["beam"].arrays()[name])


def with_body(system, body):
    return System((Placed(body),), system.joints)


def test_starting_anew_removes_the_old_rounds_and_nothing_else(tmp_path):
    for name in ("round-0.h5", "round-3.npz", "notes.txt"):
        (tmp_path / name).touch()
    archive = CorrectionFolder.create(tmp_path, case=CASE)
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]
    assert archive.read_bases(0, {}) is None


@pytest.mark.slow
def test_rounds_of_another_case_are_not_continued(kept):
    with pytest.raises(ResultFileError, match="its rounds are of another case; write to another folder"):
        CorrectionFolder.resume(kept[1], case="another strip")


def test_a_round_that_stopped_early_is_not_taken_for_one_of_another_machine(tmp_path):
    archive = CorrectionFolder.create(tmp_path, case=CASE)
    archive.simulate(0, pendulum(), RUNS["fixed"], progress=lambda _: None)
    (tmp_path / "round-0.stopped").write_text("at t = 0.5")
    again = archive.simulate(0, pendulum(), RUNS["fixed"], progress=lambda _: None)
    assert again.stopped == "at t = 0.5"
    with pytest.raises(ResultFileError, match="body 'bar' has changed"):
        archive.simulate(0, pendulum(mass=2.0), RUNS["fixed"], progress=lambda _: None)


def test_bases_before_the_first_output_belong_to_their_case(tmp_path):
    """A run that is killed before its first output leaves only its bases."""
    first = CorrectionFolder.create(tmp_path, case=CASE, inputs={"the load": "1.0"})
    first.keep_bases(0, RoundBases({}, {}, 0.0, {}))
    assert CorrectionFolder.resume(tmp_path, case=CASE, inputs={"the load": "1.0"}).read_bases(0, {})
    other = CorrectionFolder.resume(tmp_path, case=CASE, inputs={"the load": "2.0"})
    with pytest.raises(ResultFileError, match=r"another case \(the load was 1\.0 and is 2\.0\)"):
        other.read_bases(0, {})


@pytest.mark.slow
def test_bases_of_another_mesh_are_not_continued(kept):
    wall = HomogeneousSection(Isotropic(1e9, 0.3, 1000.0), 0.01)
    other = flexible_body("beam", shell_model(strip(1.0, 0.1, 2, 2), wall), (RigidInterface("root", "root"),))
    archive = CorrectionFolder.resume(kept[1], case=CASE)
    with pytest.raises(ResultFileError, match="its bases of body 'beam' have"):
        archive.read_bases(0, {"beam": FullBody(other, NodalFixedFrame("root"))})


def test_damaged_bases_are_named(tmp_path, system):
    np.savez(tmp_path / "round-0.npz", seconds=1.0)
    fulls = {"beam": system.bodies[0].body}
    with pytest.raises(ResultFileError, match=r"round-0\.npz is damaged"):
        CorrectionFolder.resume(tmp_path, case=CASE).read_bases(0, fulls)
