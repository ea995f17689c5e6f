"""One blade in BeamDyn's files and in both versions of windIO, its dialects and the messages."""

import re

import numpy as np
import pytest
from fixtures.section_tables import COUPLED, inertia

from supple.errors import ImportFormatError, ModelError
from supple.importers import files_read_with, read_section_table
from supple.importers.section_table import UPPER, fine_grid
from supple.machine import DeadForce, Fixed, System
from supple.methods.intrinsic import CLAMPED, intrinsic_body, section_line
from supple.simulation import equilibrium

GRID = np.linspace(0, 1, 11)
Z = 30 * GRID
X, Y, TWIST = -1.5 * GRID**2, 0.4 * GRID, 12 * (1 - GRID)
MASS = inertia(3.0, 0.03, -0.02, 0.05, 0.02, 0.004)
K = [(1 - 0.5 * eta) * COUPLED for eta in GRID]
M = [(1 - 0.5 * eta) * MASS for eta in GRID]


def listed(values):
    return "[" + ", ".join(f"{value:.15g}" for value in values) + "]"


def curve(values, grid=GRID):
    return f"{{grid: {listed(grid)}, values: {listed(values)}}}"


def matrices(all_of):
    rows = ", ".join(listed(each[UPPER]) for each in all_of)
    return f"{{grid: {listed(GRID)}, values: [{rows}]}}"


FIRST = f"""\
components:
  blade:
    outer_shape_bem: {{}}
    elastic_properties_mb:
      six_x_six:
        reference_axis: {{x: {curve(X)}, y: {curve(Y)}, z: {curve(Z)}}}
        twist: {curve(np.radians(TWIST))}
        stiff_matrix: {matrices(K)}
        inertia_matrix: {matrices(M)}
"""


def entries(all_of):
    pairs = zip(*UPPER, strict=True)
    return ", ".join(f"K{i + 1}{j + 1}: {listed(np.array(all_of)[:, i, j])}" for i, j in pairs)


M_ = np.array(M)
SECOND = f"""\
components:
  blade:
    reference_axis: {{x: {curve(X)}, y: {curve(Y)}, z: {curve(Z)}}}
    outer_shape:
      twist: {curve(TWIST)}
    structure:
      elastic_properties:
        stiffness_matrix: {{grid: {listed(GRID)}, {entries(K)}}}
        inertia_matrix:
          grid: {listed(GRID)}
          mass: {listed(M_[:, 0, 0])}
          cm_x: {listed(M_[:, 1, 5] / M_[:, 0, 0])}
          cm_y: {listed(M_[:, 2, 3] / M_[:, 0, 0])}
          i_edge: {listed(M_[:, 3, 3])}
          i_flap: {listed(M_[:, 4, 4])}
          i_plr: {listed(M_[:, 5, 5])}
          i_cp: {listed(-M_[:, 3, 4])}
"""

PRIMARY = (
    """\
--------- BEAMDYN with OpenFAST INPUT FILE ----
A blade of three coefficients
---------------------- SIMULATION CONTROL -----
True          QuasiStaticInit - (flag)
"DEFAULT"     DTBeam          - Time step size (s)
---------------------- GEOMETRY PARAMETER -----
1                      member_total - Total number of members (-)
11                     kp_total    - Total number of key points (-)
1 11                               - Member number; Number of key points in this member
        kp_xr                 kp_yr                 kp_zr             initial_twist
         (m)                   (m)                   (m)                  (deg)
"""
    + "".join(f" {x:.14e} {y:.14e} {z:.14e} {t:.14e}\n" for x, y, z, t in zip(X, Y, Z, TWIST, strict=True))
    + """\
---------------------- MATERIAL PARAMETER -----
"blade.dat"            BldFile     - Name of file containing properties for blade (quoted string)
END of input file
"""
)


def station(eta, *pair):
    rows = "\n\n".join("\n".join(" ".join(f"{x: .15e}" for x in row) for row in each) for each in pair)
    return f" {eta:.15e}\n{rows}\n\n"


BLADE = """\
-------- BEAMDYN V1.00.* INDIVIDUAL BLADE INPUT FILE --
Made for a test
---------------------- BLADE PARAMETERS ---------------
11                     station_total - Number of blade input stations (-)
1                      damp_type   - Damping type: 0: no damping; 1: damped
---------------------- DAMPING COEFFICIENT-------------
 mu1 mu2 mu3 mu4 mu5 mu6
 (-) (-) (-) (-) (-) (-)
 0.004 0.003 0.001 0.003 0.004 0.001
---------------------- DISTRIBUTED PROPERTIES ---------
""" + "".join(station(*each) for each in zip(GRID, K, M, strict=True))


@pytest.fixture
def files(tmp_path):
    """Writes the three forms with changes."""

    def write(*changes):
        texts = {"first.yaml": FIRST, "second.yaml": SECOND, "primary.dat": PRIMARY, "blade.dat": BLADE}
        for name, old, new in changes:
            assert old in texts[name]
            texts[name] = texts[name].replace(old, new, 1)
        for name, text in texts.items():
            (tmp_path / name).write_text(text)
        return tmp_path

    return write


def lowest(table):
    return intrinsic_body(section_line("blade", table, 21), CLAMPED).modes.frequencies[:6]


def test_three_files_of_one_blade(files):
    folder = files()
    first, second, third = (
        read_section_table(folder / name) for name in ("first.yaml", "second.yaml", "primary.dat")
    )
    for name in ("positions", "axes", "stiffness", "inertia"):
        assert getattr(second, name) == pytest.approx(getattr(first, name), abs=1e-9, rel=1e-9)
    assert first.n == 101  # pieces of a hundredth of the blade
    # BeamDyn's stations are at shares of the curve's length, windIO's of its parameter.
    assert lowest(third) == pytest.approx(lowest(first), rel=2e-3)
    assert third.axes[0, :, 0] == pytest.approx(
        [np.cos(np.radians(12)), -np.sin(np.radians(12)), 0], abs=1e-2
    )
    assert third.positions[-1] == pytest.approx([-1.5, 0.4, 30])


def test_the_curve_of_beamdyn_is_its_length(files):
    """Of a natural spline through points of a parabola; K and M linear in it."""
    table = read_section_table(files() / "primary.dat")
    _, _, stiffness, _ = table.at([0.5 * table.lengths[-1]])
    assert stiffness[0] == pytest.approx(0.75 * COUPLED, rel=2e-4)
    assert files_read_with(files() / "primary.dat") == (files() / "primary.dat", files() / "blade.dat")


def test_two_members_and_fortran_numbers(files):
    folder = files(
        ("primary.dat", "1                      member_total", "2 member_total"),
        ("primary.dat", "1 11       ", "1 6 \n 2 6    "),
        ("primary.dat", f"{Z[3]:.14e}", f"{Z[3]:.14e}".replace("e", "D")),
    )
    assert lowest(read_section_table(folder / "primary.dat")) == pytest.approx(
        lowest(read_section_table(folder / "first.yaml")), rel=3e-3
    )


@pytest.mark.parametrize(
    ("name", "old", "new", "message"),
    [
        ("primary.dat", "member_total", "members", "no line 'VALUE member_total'; is this a BeamDyn file"),
        ("primary.dat", "11                     kp", "10 kp", "line 8: 10 key points for members of 11"),
        (
            "primary.dat",
            "11                     kp",
            "two kp",
            "line 8: kp_total is two; write a whole number",
        ),
        ("primary.dat", f"{Z[3]:.14e}", "x", "line 15: a key point (x, y, z, twist) needs 4 numbers"),
        ("primary.dat", f"{Z[3]:.14e}", "2.0", "line 15: the key point is not beyond the one before in z"),
        ("primary.dat", "blade.dat", "none.dat", "none.dat: no such file"),
        ("blade.dat", "station_total", "stations", "is this a BeamDyn file, and the blade one?"),
        ("blade.dat", "DISTRIBUTED", "OTHER", "no heading 'DISTRIBUTED PROPERTIES'"),
        ("blade.dat", "11                     st", "12 st", "12 stations need 13 lines each"),
        ("blade.dat", " 1.000000000000000e-01\n", " 0.0\n", "line 26: stations go from 0 (root) to 1 (tip)"),
        ("blade.dat", " 0.000000000000000e+00\n", " 0.01\n", "line 11: stations go from 0 (root) to 1 (tip)"),
        ("blade.dat", " 3.000000000000000e+00", " 3.1", "line 11: its mass differs with the direction"),
        ("blade.dat", " 8.000000000000000e+05", " 8.0e", "line 12: a row of a matrix needs 6 numbers"),
    ],
)
def test_mistakes_in_beamdyn_are_named(files, name, old, new, message):
    folder = files((name, old, new))
    with pytest.raises((ImportFormatError, ModelError), match=re.escape(message)):
        read_section_table(folder / "primary.dat")


@pytest.mark.parametrize(
    ("name", "old", "new", "message"),
    [
        (
            "first.yaml",
            "six_x_six",
            "timoschenko_hawc",
            "no entry components.blade.elastic_properties_mb.six",
        ),
        (
            "first.yaml",
            "stiff_matrix: {grid: [0, 0.1,",
            "stiff_matrix: {grid: [0,",
            "has 10 grid points and 11",
        ),
        (
            "first.yaml",
            "inertia_matrix: {grid: [0, 0.1",
            "inertia_matrix: {grid: [0, 0",
            "two numbers, ascending",
        ),
        ("first.yaml", "values: [[8", "values: [[x8", "holds entries that are not numbers"),
        (
            "first.yaml",
            "values: [[800000",
            "values: [[-800000",
            "blade, section at 0: stiffness 11 is -8e+05",
        ),
        (
            "second.yaml",
            "elastic_properties:",
            "elastic_properties:\n        point_mass: {}",
            "has a point_mass",
        ),
        ("second.yaml", "K12: [0, ", "K12: [", "K12 has 10 values on 11 grid points; give as many"),
        ("second.yaml", "i_edge", "i_flap_", "inertia_matrix.i_flap_; it takes grid, mass, cm_x"),
    ],
)
def test_mistakes_in_windio_are_named(files, name, old, new, message):
    folder = files((name, old, new))
    with pytest.raises((ImportFormatError, ModelError), match=re.escape(message)):
        read_section_table(folder / name)


def test_axes_by_the_text_of_schema_2_are_refused(files):
    """With x to the trailing edge, K44 is flapwise, and less than K55."""
    swapped = SECOND.replace("K44:", "K_:").replace("K55:", "K44:").replace("K_:", "K55:")
    folder = files()
    (folder / "second.yaml").write_text(swapped)
    with pytest.raises(ImportFormatError, match="as if x pointed to the trailing edge"):
        read_section_table(folder / "second.yaml")


def test_an_axis_that_is_shorter_than_the_matrices(files):
    folder = files(("first.yaml", f"z: {curve(Z)}", f"z: {curve(Z[:-1], GRID[:-1])}"))
    with pytest.raises(
        ImportFormatError, match=r"reference_axis\.z is given from 0 to 0\.9, the sections from 0 to 1"
    ):
        read_section_table(folder / "first.yaml")


def test_a_grid_is_made_fine_where_it_is_coarse():
    fine = fine_grid(np.array([0, 0.01, 0.5, 1.0]))
    assert np.diff(fine).max() <= 0.01 + 1e-12
    assert {0, 0.01, 0.5, 1.0} <= set(fine)
    assert len(fine) == 101


def beamdyn(tmp_path, points, stiffness):
    """Files of a uniform beam through key points (x, y, z, twist)."""
    head, tail = PRIMARY.split("(deg)\n")
    tail = tail[tail.index("-----") :]
    n = len(points)
    head = head.replace("11                     kp", f"{n} kp").replace("1 11  ", f"1 {n} ")
    rows = "".join(" ".join(f"{x:.9e}" for x in row) + "\n" for row in points)
    (tmp_path / "primary.dat").write_text(f"{head}(deg)\n{rows}{tail}")
    mass = np.diag([1.0, 1, 1, 0.5, 0.5, 1])
    stations = "".join(station(eta, np.diag(stiffness), mass) for eta in (0, 1))
    (tmp_path / "blade.dat").write_text(BLADE[: BLADE.index(" 0.00000")].replace("11  ", "2 ") + stations)
    return read_section_table(tmp_path / "primary.dat")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("points", "stiffness", "force", "tip", "digits"),
    [
        pytest.param(
            [(0, 0, z, 9 * z) for z in range(11)],
            [8.2604167e9, 8.2604167e9, 2.5e10, 0.520833e9, 0.130208333e9, 0.141872656e9],
            (0, -4e6, 0),
            (1.71810805, -3.59245231, -1.14114462),
            1e-8,
            id="twisted",
        ),
        pytest.param(
            [(0, 0, 0, 0), (7.61205, 0, 38.2683, 0), (29.2893, 0, 70.7107, 0)],
            [41.6667e5, 41.6667e5, 1e7, 8.333e5, 8.333e5, 8.333e5],
            (0, 600, 0),
            (-13.46, 53.35, -23.58),
            5e-3,
            id="curved",
        ),
    ],
)
def test_beamdyn_itself(tmp_path, points, stiffness, force, tip, digits):
    """Tips of OpenFAST's regression tests bd_static_twisted_with_k1, bd_curved_beam (r-test)."""
    table = beamdyn(tmp_path, points, stiffness)
    body = intrinsic_body(section_line("beam", table, 41), CLAMPED)
    clamp, load = Fixed(first="ground", second="beam.root"), DeadForce(at="beam.tip", force=force)
    places = body.places(equilibrium(System([body], [clamp], [load])).solution.bodies["beam"])[1]
    found = places[0, -1] - table.positions[-1]
    assert found == pytest.approx(np.array(tip), abs=digits + 1e-3 * np.linalg.norm(tip))
