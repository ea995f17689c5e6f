"""Errors of the cases of a sweep against runs with all coordinates, and the cases that run again."""

from __future__ import annotations

import shutil
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from fixtures.abaqus_text import abaqus_text
from fixtures.strip_case import CASE

from supple.mesh import strip
from supple.simulation import simulate
from supple.sweeps import CaseTable, read_sweep, sweep, sweep_status, swept_case
from supple.sweeps.certificate import Certificate
from supple.sweeps.certified_group import certified_group
from supple.sweeps.leading_columns import with_principal_bases
from supple.sweeps.part_file import part_path
from supple.sweeps.plan import read_plan
from supple.sweeps.swept_group import swept_group

pytestmark = pytest.mark.slow

ACCURACY = "accuracy = { relative = 1e-3, instants = 6, directions = 2 }"
MORE_MODES = "modes = 8, " + ACCURACY.replace("1e-3", "1e-2")
TABLE = CaseTable(
    {
        "gravity[2]": [-2.0, -9.81, -30.0, -60.0],
        "gravity[1]": [0.0, 4.0, 0.0, 9.0],
        "body.strip.damping.beta": [0.002, 0.004, 0.001, 0.002],
    }
)


@pytest.fixture(scope="module")
def soft_strip(tmp_path_factory):
    """The case file of a strip that bends by an eighth of its length; its reduction corrects itself."""
    folder = tmp_path_factory.mktemp("strip")
    (folder / "strip.inp").write_text(abaqus_text(strip(1.0, 0.1, 3, 2)))
    text = CASE.replace("2.1e11", "2.1e9").replace("duration = 0.4", "duration = 0.06")
    before, _, after = text.partition("reduction = ")
    after = after[after.index("\n") :]
    text = f'{before}reduction = {{ basis = "craig-bampton", {ACCURACY} }}{after}'
    (folder / "strip.toml").write_text(text)
    return folder / "strip.toml"


def run(case, folder):
    with ThreadPoolExecutor(1) as executor:
        return sweep(case, TABLE, folder, executor=executor)


@pytest.fixture(scope="module")
def swept(soft_strip):
    """The folder of its sweep."""
    folder = (soft_strip.parent / "out").resolve()
    run(soft_strip, folder)
    return folder


def true_errors(folder):
    """Largest RMS error of the nodes of each case."""
    plan, found = read_plan(folder), []
    for number in range(plan.n_cases):
        group = certified_group(folder, plan, int(plan.group[number])).group
        own = swept_case(folder, number)
        full = group.in_full(own.case, group.fulls(own.case))
        there, here = (
            system.bodies[0].body.positions(simulate(system, own.run).bodies["strip"])
            for system in (full, own.system)
        )
        found.append(np.sqrt(np.mean(np.sum((there - here) ** 2, axis=2), axis=1)).max())
    return np.array(found)


def test_every_case_states_its_error(swept):
    """The basis is enriched for the case that moves most, though another one was corrected first."""
    read, true = read_sweep(swept), true_errors(swept)
    ratio = read.basis_error.values / true
    # Two cases have full estimates, the others scaled indicators.
    assert 0.95 < ratio.min() <= ratio.max() < 1.1
    certificate = certified_group(swept, read_plan(swept), 0).certificate
    assert [each.case for each in certificate.representatives] == [3, 0]
    assert certificate.spread("strip") < 1.1
    assert (read.runs == 1).all()
    assert (read.basis_error <= read.allowed_error).all()
    # Step, Newton and model have their shares besides.
    assert (read.estimated_error > read.basis_error).all()
    errors = sweep_status(swept).errors
    assert (errors.n_estimated, errors.largest) == (4, float(read.estimated_error.max()))


def test_cases_above_their_accuracy_run_again_and_nothing_twice(swept, soft_strip, tmp_path, monkeypatch):
    """The first basis knows two cases in which the strip moves little; what was lost is all that is done."""
    module = sys.modules["supple.sweeps.certified_group"]
    monkeypatch.setattr(module, "training_cases", lambda _plan, cases: list(cases)[:2])
    folder = (tmp_path / "again").resolve()
    folder.mkdir()
    shutil.copytree(swept / "bodies", folder / "bodies")
    status = run(soft_strip, folder)
    assert (status.n_ran, status.n_again, status.exit_code) == (4, 2, 0)
    read = read_sweep(folder)
    assert read.runs.values.tolist() == [1, 1, 2, 2]
    assert (read.basis_error <= read.allowed_error).all()
    ratio = read.basis_error.values / true_errors(folder)
    assert 0.95 < ratio.min() <= ratio.max() < 1.1
    assert {own.name for own in (folder / "certificates").glob("*/*")} == {
        "00000-0",
        "00000-1-000002",
        "00000-1-000003",
    }
    part_path(folder, 1).unlink()
    written = {path: path.stat().st_mtime_ns for path in folder.rglob("*.h5")}
    assert run(soft_strip, folder).n_ran == 4
    now = {path: path.stat().st_mtime_ns for path in folder.rglob("*.h5")}
    assert {path for path in now if now[path] != written.get(path)} == {part_path(folder, 1)}
    assert np.array_equal(read_sweep(folder).statistics.values, read.statistics.values)


def test_full_estimates_decide_where_scaled_indicators_exceed(swept, soft_strip, tmp_path, monkeypatch):
    """An effectivity that is a thousand times too large enriches no basis and repeats no case."""
    true = certified_group(swept, read_plan(swept), 0)
    original = Certificate.effectivity
    monkeypatch.setattr(Certificate, "effectivity", lambda self, body: 1e3 * original(self, body))
    folder = (tmp_path / "large").resolve()
    folder.mkdir()
    shutil.copytree(swept / "bodies", folder / "bodies")
    run(soft_strip, folder)
    found, read = certified_group(folder, read_plan(folder), 0), read_sweep(folder)
    assert found.group.bodies.reduced["strip"].r == true.group.bodies.reduced["strip"].r
    assert {each.case for each in found.certificate.representatives} == {0, 1, 2, 3}
    assert (read.runs == 1).all()
    ratio = read.basis_error.values / read_sweep(swept).basis_error.values
    assert 0.9 < ratio.min() <= ratio.max() < 1.05


def test_many_cases_run_in_the_columns_in_which_they_move(soft_strip, tmp_path, monkeypatch):
    """Of a basis with more columns than are needed; the errors are stated with those left."""
    monkeypatch.setattr(sys.modules["supple.sweeps.certified_group"], "MANY", len(TABLE))
    case, folder = soft_strip.with_name("many.toml"), (tmp_path / "fewer").resolve()
    case.write_text(soft_strip.read_text().replace(ACCURACY, MORE_MODES))
    run(case, folder)
    plan = read_plan(folder)
    whole, fewer = swept_group(folder, plan, 0), certified_group(folder, plan, 0).group
    assert fewer.bodies.reduced["strip"].r < whole.bodies.reduced["strip"].r
    read = read_sweep(folder)
    assert (read.runs == 1).all()
    assert (read.basis_error <= read.allowed_error).all()
    ratio = read.basis_error.values / true_errors(folder)
    # Ten times the error of the other tests: estimates are of first order.
    assert 0.99 < ratio.min() <= ratio.max() < 1.2
    # Where the motion of a case would change, the bases stay as they are.
    monkeypatch.setattr(sys.modules["supple.sweeps.leading_columns"], "SHARE", 1e-9)
    assert with_principal_bases(whole, list(range(plan.n_cases)))[0] is whole
