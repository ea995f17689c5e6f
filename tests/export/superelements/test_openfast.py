"""Files for OpenFAST are read back: ExtPtfm's as its source reads them, BeamDyn's by this library."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import block_diag, eigvalsh

from supple.errors import ModelError
from supple.export import write_beamdyn, write_extptfm
from supple.importers import SectionTable, read_beamdyn_sections
from supple.importers.section_table import twisted_axes


def read_extptfm(path):
    """Matrices by name and the table of loads, by the marks at which ExtPtfm looks."""
    lines, found = path.read_text().splitlines(), {}
    n = next(int(line[11:]) for line in lines if line.upper().startswith("!DIMENSION"))
    for at, line in enumerate(lines):
        for name in ("MASS MATRIX", "STIFFNESS MATRIX", "DAMPING MATRIX"):
            if line.upper().startswith(f"!{name}"):
                found[name] = np.array([row.split() for row in lines[at + 2 : at + 2 + n]], dtype=float)
        if line.upper().startswith("!LOADING"):
            found["LOADING"] = np.array([row.split() for row in lines[at + 2 :]], dtype=float)
    return found


def test_extptfm_reads_the_superelement_clamped_elsewhere(form, craig_bampton, tmp_path):
    path = write_extptfm(tmp_path / "tower.dat", form, "far tip/µ", gravity=(0, 0, -9.81))
    found = read_extptfm(path)
    K, M = found["STIFFNESS MATRIX"], found["MASS MATRIX"]
    squares = np.sort(np.linalg.eigvals(np.linalg.solve(M, K)).real)
    np.testing.assert_allclose(np.sqrt(squares)[:4] / (2 * np.pi), form.frequencies(["root"])[:4], rtol=1e-9)
    np.testing.assert_allclose(found["DAMPING MATRIX"], 1e-5 * K, atol=1e-11 * abs(K).max())
    assert found["LOADING"].shape == (2, 1 + len(K))
    r = craig_bampton.r
    moments = craig_bampton.gram[np.r_[:6, 6 + 3 * r : 6 + 4 * r], 2]  # of a unit acceleration along z
    kept = np.r_[6:12, 12 : len(form.mass)]
    expected = -9.81 * (form.to_body.T @ moments)[kept]
    np.testing.assert_allclose(found["LOADING"][0, 1:], expected, atol=1e-9 * abs(expected).max())
    with pytest.raises(ModelError, match="no interface 'tap'"):
        write_extptfm(path, form, "tap")


@pytest.mark.parametrize("n", [200, 300])
def test_loads_fit_in_the_lines_that_extptfm_reads(form, n, tmp_path):
    """Its source reads 4096 characters of a line, and allows for outputs of 200 modes."""
    modes = np.eye(n) * 1e6
    blocks = {
        name: block_diag(getattr(form, name)[:12, :12], modes) for name in ("stiffness", "mass", "damping")
    }
    large = replace(form, **blocks, to_body=np.zeros((6, 12 + n)))
    if n == 300:
        with pytest.raises(ModelError, match=r"306 coordinates has \d+: keep fewer modes"):
            write_extptfm(tmp_path / "tower.dat", large, "far tip/µ")
        return
    path = write_extptfm(tmp_path / "tower.dat", large, "far tip/µ", gravity=(0, 0, -9.81))
    assert max(map(len, path.read_text().splitlines()[-2:])) <= 4096
    assert read_extptfm(path)["LOADING"].shape == (2, 207)


def test_extptfm_reads_a_superelement_on_springs(form, tmp_path):
    """Compliances add: that of the clamped body, and that of the springs, seen from the tower."""
    k = np.diag([3e4, 2e4, 5e4, 400.0, 300.0, 200.0])
    k[0, 4] = k[4, 0] = 500.0
    path = write_extptfm(tmp_path / "pile.dat", form, "far tip/µ", springs={"root": (k, 1e-3 * k)})
    assert "root on springs, all other interfaces clamped" in path.read_text()
    found = read_extptfm(path)
    K, M, C = (found[f"{name} MATRIX"] for name in ("STIFFNESS", "MASS", "DAMPING"))
    assert abs(K[:6, 6:]).max() < 1e-9 * abs(K).max()  # the modes are those with the tower's end clamped
    to_root = np.eye(6)
    x, y, z = form.positions[1] - form.positions[0]
    to_root[:3, 3:] = [[0, z, -y], [-z, 0, x], [y, -x, 0]]
    clamped = np.linalg.inv(form.stiffness[6:12, 6:12])
    expected = clamped + to_root @ np.linalg.solve(k, to_root.T)
    np.testing.assert_allclose(np.linalg.inv(K[:6, :6]), expected, atol=1e-8 * abs(expected).max())
    whole = form.stiffness.copy()
    whole[:6, :6] += k
    np.testing.assert_allclose(eigvalsh(K, M), eigvalsh(whole, form.mass), rtol=1e-7)
    damped = 1e-5 * form.stiffness
    damped[:6, :6] += 1e-3 * k
    np.testing.assert_allclose(eigvalsh(C, M), eigvalsh(damped, form.mass), rtol=1e-6, atol=1e-12)
    with pytest.raises(ModelError, match="no interface 'rot'"):
        write_extptfm(path, form, "far tip/µ", springs={"rot": (k, k)})


def blade(n=15):
    s = np.linspace(0.0, 1.0, n)
    positions = np.column_stack([0.5 * s**2, -0.3 * s**3, 20.0 * s])
    slopes = np.column_stack([s, -0.9 * s**2, np.full(n, 20.0)])
    stiffness = np.array([np.diag([1e8, 1.2e8, 3e9, 4e8, 2e8, 1e8]) * (1.1 - k) for k in s])
    stiffness[:, 3, 5] = stiffness[:, 5, 3] = 1e7
    inertia = np.array([np.diag([50.0, 50.0, 50.0, 8.0, 4.0, 12.0]) * (1.1 - k) for k in s])
    return SectionTable(positions, twisted_axes(slopes, np.radians(12.0 * (1 - s))), stiffness, inertia)


def test_a_blade_for_beamdyn_is_read_back(tmp_path):
    table = blade()
    primary, sections = write_beamdyn(tmp_path / "blade.dat", table, title=["clamped at root: 1.5"])
    again = read_beamdyn_sections(primary)
    assert sections.name == "blade_blade.dat"
    assert "clamped at root: 1.5" in sections.read_text()
    shares = table.lengths / table.lengths[-1]
    places, axes, stiffness, inertia = again.at(shares * again.lengths[-1])
    np.testing.assert_allclose(places, table.positions, atol=2e-4)
    np.testing.assert_allclose(axes, table.axes, atol=2e-3)
    np.testing.assert_allclose(stiffness, table.stiffness, rtol=1e-6)
    np.testing.assert_allclose(inertia, table.inertia, rtol=1e-6)


def test_a_blade_that_does_not_lead_along_z_is_refused(tmp_path):
    table = blade()
    turned = SectionTable(
        table.positions[:, [2, 0, 1]], table.axes[:, [2, 0, 1]], table.stiffness, table.inertia
    )
    with pytest.raises(ModelError, match="ascending in z"):
        write_beamdyn(tmp_path / "blade.dat", turned)
    assert not (tmp_path / "blade.dat").exists()
