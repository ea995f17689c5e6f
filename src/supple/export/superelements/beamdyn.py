"""Blades for OpenFAST: BeamDyn's primary file with the key points, and the blade file with 6 x 6 matrices.

Source: BeamDyn user's guide, input files (OpenFAST 4).
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from supple.arrays import FloatArray
from supple.errors import ModelError
from supple.export.ascii_file import write_ascii
from supple.importers import SectionTable
from supple.importers.section_table import twisted_axes

__all__ = ["blade_file_of", "write_beamdyn"]


_LARGEST_TILT = 0.02
"""Largest angle between a section's normal and BeamDyn's curve, rad; a larger angle is a ModelError."""

_ORDER = 5

_CONTROL = """\
---------------------- SIMULATION CONTROL --------------------------------------
False         Echo            - Echo input data to "<RootName>.ech"? (flag)
True          QuasiStaticInit - Use quasi-static pre-conditioning with centripetal accelerations? (flag)
          0   rhoinf          - Numerical damping parameter for generalized-alpha integrator
          2   quadrature      - Quadrature method: 1=Gaussian; 2=Trapezoidal (switch)
          2   refine          - Refinement factor for trapezoidal quadrature (-)
"DEFAULT"     n_fact          - Factorization frequency for the Jacobian in N-R iteration (-)
"DEFAULT"     DTBeam          - Time step size (s)
"DEFAULT"     load_retries    - Number of factored load retries before quitting the simulation (-)
"DEFAULT"     NRMax           - Max number of iterations in Newton-Raphson algorithm (-)
"DEFAULT"     stop_tol        - Tolerance for stopping criterion (-)
"DEFAULT"     tngt_stf_fd     - Use finite differenced tangent stiffness matrix? (flag)
"DEFAULT"     tngt_stf_comp   - Compare analytical finite differenced tangent stiffness matrix? (flag)
"DEFAULT"     tngt_stf_pert   - Perturbation size for finite differencing (-)
"DEFAULT"     tngt_stf_difftol - Maximum allowable relative difference (-)
True          RotStates       - Orient states in the rotating frame during linearization? (flag)
---------------------- GEOMETRY PARAMETER --------------------------------------"""

_REST = """\
---------------------- PITCH ACTUATOR PARAMETERS -------------------------------
False         UsePitchAct     - Whether a pitch actuator should be used (flag)
        200   PitchJ          - Pitch actuator inertia (kg-m^2) [used only when UsePitchAct is true]
      2E+07   PitchK          - Pitch actuator stiffness (kg-m^2/s^2) [used only when UsePitchAct is true]
     500000   PitchC          - Pitch actuator damping (kg-m^2/s) [used only when UsePitchAct is true]
---------------------- OUTPUTS -------------------------------------------------
False         SumPrint        - Print summary data to "<RootName>.sum" (flag)
"ES10.3E2"    OutFmt          - Format used for text tabular output, excluding the time channel.
          0   NNodeOuts       - Number of nodes to output to file [0 - 9] (-)
          1   OutNd           - Nodes whose values will be output (-)
              OutList         - The next line(s) contains a list of output parameters
"TipTDxr, TipTDyr, TipTDzr"
END of input file (the word "END" must appear in the first 3 columns of this last OutList line)
---------------------------------------------------------------------------------------"""


def write_beamdyn(
    path: Path | str, table: SectionTable, *, title: Sequence[str] = (), beta: float = 0.0
) -> tuple[Path, Path]:
    """Write a blade for BeamDyn: the primary file and `NAME_blade.dat` beside it; returns both paths.

    Every section is a key point. BeamDyn's blade axes are those of the table: z from the root to the tip,
    x to the suction side, the root at the origin.

    title : lines for the headers of the files, such as reference frequencies
    beta : damping by strain rate, s: coefficient of the stiffness, for all six strains

    Raises
    ------
    ModelError          fewer than three sections, a curve that does not ascend in z, or sections that are not
                        normal to the curve
    ResultFileError     a file cannot be written
    """
    places = table.positions - table.positions[0]
    if len(places) < 3 or (np.diff(places[:, 2]) <= 0).any():
        raise ModelError(
            "BeamDyn needs at least three key points, ascending in z from root to tip: rotate the body's "
            "axes so that z points along the blade"
        )
    twist = _twist(table)
    primary, blade = Path(path), blade_file_of(path)
    lines = _primary(np.column_stack([places, np.degrees(twist)]), blade.name, title)
    return write_ascii(primary, lines), write_ascii(blade, _blade(table, title, beta))


def blade_file_of(path: Path | str) -> Path:
    """The blade file beside a primary file."""
    return Path(path).with_name(f"{Path(path).stem}_blade.dat")


def _twist(table: SectionTable) -> FloatArray:
    """Twist (n,) of the sections about -z, rad, without jumps; ModelError for inclined sections."""
    from scipy.interpolate import CubicSpline

    z = table.positions[:, 2]
    slopes = CubicSpline(z, table.positions[:, :2], bc_type="natural")(z, 1)
    along = np.column_stack([slopes, np.ones(len(z))])
    untwisted = twisted_axes(along, np.zeros(len(z)))
    tilt = np.arccos(np.clip(np.einsum("ni,ni->n", untwisted[:, :, 2], table.axes[:, :, 2]), -1.0, 1.0))
    if tilt.max() > _LARGEST_TILT:
        k = int(tilt.argmax())
        raise ModelError(
            f"section {k} is inclined by {np.degrees(tilt[k]):.1f} degrees, and BeamDyn's sections are "
            "normal to the curve through their positions: give more sections, or axes along the curve"
        )
    x = table.axes[:, :, 0]
    across = np.einsum("ni,nik->nk", x, untwisted)
    return np.unwrap(-np.arctan2(across[:, 1], across[:, 0]))


def _primary(points: FloatArray, blade: str, title: Sequence[str]) -> list[str]:
    n = len(points)
    return [
        "--------- BEAMDYN with OpenFAST INPUT FILE -------------------------------------------",
        _one_line(title),
        *_CONTROL.splitlines(),
        f"{1:11d}   member_total    - Total number of members (-)",
        f"{n:11d}   kp_total        - Total number of key points (-)",
        f"     1     {n}         - Member number; Number of key points in this member",
        "        kp_xr           kp_yr           kp_zr           initial_twist",
        "         (m)             (m)             (m)              (deg)",
        *_rows(points),
        "---------------------- MESH PARAMETER ------------------------------------------",
        f"{_ORDER:11d}   order_elem      - Order of interpolation (basis) function (-)",
        "---------------------- MATERIAL PARAMETER --------------------------------------",
        f'"{blade}"    BldFile         - Name of file containing properties for blade (quoted string)',
        *_REST.splitlines(),
    ]


def _blade(table: SectionTable, title: Sequence[str], beta: float) -> list[str]:
    lines = [
        " ------- BEAMDYN INDIVIDUAL BLADE INPUT FILE --------------------------",
        _one_line(title),
        " ---------------------- BLADE PARAMETERS --------------------------------------",
        f"{table.n:5d}   station_total    - Number of blade input stations (-)",
        f"    {int(beta > 0)}   damp_type        - Damping type: 0: no damping; 1: damped",
        " ---------------------- DAMPING COEFFICIENT------------------------------------",
        "   mu1        mu2        mu3        mu4        mu5        mu6",
        "   (-)        (-)        (-)        (-)        (-)        (-)",
        "".join(f"   {beta:.9g}" for _ in range(6)),
        " ---------------------- DISTRIBUTED PROPERTIES---------------------------------",
    ]
    shares = table.lengths / table.lengths[-1]
    for share, stiffness, inertia in zip(shares, table.stiffness, table.inertia, strict=True):
        lines += [f"{share:.16g}", *_rows(stiffness), "", *_rows(inertia), ""]
    return lines


def _one_line(title: Sequence[str]) -> str:
    return "; ".join(title) or "blade"


def _rows(matrix: FloatArray) -> list[str]:
    return ["".join(f" {value:23.16e}" for value in row) for row in matrix]
