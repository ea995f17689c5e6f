"""Small valid files of every kind that supple reads, and the reader of each."""

from __future__ import annotations

import io
import multiprocessing as mp
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import h5py
import numpy as np
from scipy.io import netcdf_file
from scipy.sparse import csc_array

import supple as sp
from supple.cases import read_case
from supple.errors import SuppleError
from supple.importers import (
    MatrixRole,
    read_deck,
    read_exodus,
    read_labelled_matrix,
    read_matrix,
    read_nodes,
    read_polar,
    read_rotor,
    read_stations,
    read_vtu,
    read_windio_blade,
)
from supple.importers.time_table import read_time_table
from supple.results.descriptions import describe_result
from supple.simulation import simulate_recorded
from supple.storage import (
    ResultFile,
    holds_reduced_body,
    read_header,
    read_interface_names,
    read_last_instant,
    read_sound_part,
)

REPOSITORY = Path(__file__).resolve().parents[2]


@dataclass(frozen=True)
class Seed:
    """A valid file.

    name : of the file; the suffix determines the reader
    companions : further files in the same folder, by name
    """

    name: str
    content: bytes
    companions: Mapping[str, bytes] = field(default_factory=dict)


@dataclass(frozen=True)
class Kind:
    """A kind of file: its reader, and seeds.

    is_hdf5 : read by the HDF5 library, which may hang on broken metadata: left out of the quick form
    """

    label: str
    reader: Callable[[Path], object]
    seeds: tuple[Seed, ...]
    is_hdf5: bool = False


def kinds(folder: Path) -> Iterator[Kind]:
    """Every kind; files that only the HDF5 library can create are created in `folder`."""
    yield from _meshes()
    yield from _matrices(folder)
    yield from _tables()
    yield from _cases()
    yield from _results(folder)


_INP = """\
*HEADING
square of two shells
*NODE, NSET=ALL
1, 0., 0., 0.
2, 1., 0., 0.
3, 1., 1., 0.
4, 0., 1., 0.
5, 2., 0., 0.
6, 2., 1., 0.
*ELEMENT, TYPE=S4, ELSET=QUADS
1, 1, 2, 3, 4
*ELEMENT, TYPE=S3, ELSET=TRIANGLES
2, 2, 5, 6
3, 2, 6, 3
*NSET, NSET=ROOT
1, 4
*NSET, NSET=TIP, GENERATE
5, 6, 1
*ELSET, ELSET=BOTH
QUADS, TRIANGLES
"""
_BDF = """\
SOL 103
CEND
BEGIN BULK
PARAM,WTMASS,1.0
CORD2C,7,0,0.,0.,0.,0.,0.,1.
,1.,0.,0.
GRID,10,,0.,0.,0.
GRID,20,,1.,0.,0.
GRID,30,,1.,1.,0.
GRID    40              0.      1.      0.
GRID*   50                              2.              0.
*       0.
GRID,60,7,2.236067977499790,26.5650511770780,0.
GRID,99,,0.,0.5,0.
CTRIA3,1,7,10,20,30
CTRIA3,2,7,10,30,40
CQUAD4,3,7,20,50,60,30
PSHELL,7,5,0.1,5
MAT1,5,2.1+11,,.3,7850.
RBE2,100,99,123456,10,40
SPC1,1,123456,10,THRU,40
ASET1,123456,50,60
ENDDATA
"""
_SOLID_BDF = """\
GRID,1,,0.,0.,0.
GRID,2,,1.,0.,0.
GRID,3,,0.,1.,0.
GRID,4,,0.,0.,1.
CTETRA,1,3,1,2,3,4
PSOLID,3,5
MAT1,5,2.1+11,,.3,7850.
CBAR,9,8,1,2,0.,0.,1.
PBARL,8,5,,BAR
,0.1,0.2
"""
# Superelements that are moved, mirrored and joined by hand, and a mass at a grid of the main bulk data.
_PARTS_BDF = """\
BEGIN BULK
GRID,1,,1.,0.,0.
GRID,11,,1.,0.,0.
GRID,12,,2.,0.,0.
GRID,13,,2.,1.,0.
POINT,14,,3.,0.,0.
POINT,15,,3.,1.,0.
POINT,16,,3.,0.,1.
CONM2,9,1,,5.
SELOC,2,1,2,3,11,12,13
SEBULK,2,PRIMARY,,MANUAL
SEBULK,3,MIRROR,2,AUTO,1.-4
SEMPLN,3,PLANE,14,15,16
SECONCT,1,2
,2,1,3,4
SEBNDRY,1,ALL,2,THRU,3
SEEXCLD,1,2,4
BEGIN SUPER=1
GRID,1,,0.,0.,0.
GRID,2,,1.,0.,0.
GRID,3,,1.,1.,0.
GRID,4,,0.,1.,0.
CQUAD4,1,7,1,2,3,4
PSHELL,7,5,.1,5
MAT1,5,2.1+11,,.3,7850.
CELAS2,6,4.+6,1,2,4,2
BEGIN BULK SUPER=2
GRID,1,,0.,5.,0.
GRID,2,,0.,6.,0.
GRID,3,,-1.,6.,0.
GRID,4,,-1.,5.,0.
CQUAD4,1,7,1,2,3,4
CBAR,2,8,1,3,0.,0.,1.
RBE2,5,2,123456,3
PBAR,8,5,4.-4,1.-8,2.-8,1.-8
PCOMP,7
,5,.1,30.
MAT1,5,2.1+11,,.3,7850.
BEGIN SUPER=3
PLOAD2,1,2.,1
ENDDATA
"""

_DECK_BDF = """\
SOL 103
CEND
SPC = 1
MPC = 8
NSM = 6
K2GG = 2.0*KADD
BEGIN BULK
GRDSET,,,,,,,6
BAROR,,18,,,0.,0.,1.
CORD2R,3,,0.,0.,0.,0.,1.,1.
,1.,1.,0.
GRID,1,,0.,0.,0.
=,*(1),=,*(1.),==
=1
GRID,4,,0.,1.,0.,3
GRID,5,,0.,0.,1.
GRID,6,,1.,0.,1.,,45
GRID,7,,1.5,1.,.5
SPOINT,77
CPENTA,1,13,1,2,4,5,6,7
,8
GRID,8,,.5,0.,0.
CPYRAM,2,13,1,2,6,5,4
PSOLID,13,25,3
MAT9,25,2.,1.,1.,0.,0.,0.,2.
,1.,0.,0.,0.,2.,0.,0.,0.
,1.,0.,0.,1.,0.,1.,7.
CQUAD8,3,14,1,2,6,5,8
,,,.1,.1,,.2,30.,.01
CTRIA6,4,15,1,2,4,8
PSHELL,14,26,.1,26,,26,,1.
PCOMP,15,-.1,1.,,,,,SYM
,27,.1,45.,YES,,.2,-45.
MAT1,26,2.1+11,,.3,7850.
MAT8,27,140.,10.,.3,5.,5.,3.,1.6
CBAR,5,,1,2
CBEAM,6,19,2,3,5,,,GGO
,4,56,.1,.2
PBARL,18,26,,BOX
,.1,.2,.01,.02
PBEAM,19,26,.01,1.-5,1.-5,,1.-5
,,,,,,,,
,YES,1.,.02,1.-5
,.1
,.8,.8,,,1.,,,,
,.1,.2
CBEND,7,20,1,2,.5,1.,0.,1
PBEND,20,26,.01,1.-5,1.-5,1.-5
CONROD,8,3,7,26,.1,.2
CTUBE,9,21,3,7
PTUBE,21,26,.1,.01
CSHEAR,10,22,1,2,6,5
PSHEAR,22,26,.1
CELAS1,11,23,1,3,2,3
CDAMP4,12,.5,77
PELAS,23,5.
CBUSH,13,24,1,2,0.,0.,1.
,.25
PBUSH,24,K,1.,2.,3.
,,B,.1
CONM2,14,3,3,2.,.1,.2,.3
,5.,.5,6.,.25,.125,7.
CMASS2,15,2.,3,1
NSML1,6,PSHELL,3.,14,THRU,15
RBE1,16,1,123,3,23,4,3
,UM,5,123,7,12
RBE2,17,1,126,5,THRU,7
RBE3,18,,3,123456,1.,123456,5,6
,2.,12,7
RBAR,19,2,7,123456
MPC,5,1,2,2.,2,1,-3.
,,4,3,.5,77,0,4.
MPCADD,8,5
SPC,1,1,12,0.,2,3
SPC1,1,6,1,THRU,5
ASET1,123,1,THRU,3
DMIG,KADD,0,6,1,0
DMIG,KADD,1,1,,1,1,4.
,2,2,-2.
CGAP,20,6,1,2
FORCE,1,1,,1.,1.
BEGIN SUPER=4
GRID,1,,0.,0.,0.
GRID,2,,1.,0.,0.
CROD,1,1,1,2
PROD,1,2,1.
MAT1,2,1.,,.3
ENDDATA 1b2c
"""
_DMIG = """\
DMIG    KAA     0       6       2       0
DMIG*   KAA                            1               1
*                      1               1 2.000000000D+00
*                      1               2-1.000000000D+00
DMIG*   KAA                            1               2
*                      1               2 2.000000000D+00
DMIG    MAA     0       6       1       0
DMIG,MAA,1,1,,1,1,1.5
"""

_STEEL_INP = "*MATERIAL, NAME=STEEL\n*ELASTIC\n2.1E11, 0.3, 20.\n2.0E11, 0.3, 200.\n*DENSITY\n7850.\n"
_DECK_INP = (
    _INP.partition("*ELEMENT")[0]
    + _STEEL_INP
    + """\
*NODE
11, 0., 0., 1.
12, 1., 0., 1.
13, 1., 1., 1.
14, 0., 1., 1.
21, 0., 0., 2.
22, 1., 0., 2.
23, 1., 1., 2.
24, 0., 1., 2.
31, 0., 0., 3.
33, 2., 0., 3.
*NGEN, NSET=BETWEEN
31, 33, 1
*NODE, NSET=ABOVE
51, 0., 0., 4.
52, 1., 0., 4.
53, 2., 0., 4.
*NFILL, NSET=FILLED
BETWEEN, ABOVE, 2, 10
*ELEMENT, TYPE=C3D8R, ELSET=SOLID
1, 1, 2, 3, 4, 11, 12, 13, 14
*ELEMENT, TYPE=S4R, ELSET=SKIN
2, 21, 22, 23, 24
*ELEMENT, TYPE=B32, ELSET=BEAM
3, 1, 11, 21
*ELEMENT, TYPE=SPRINGA, ELSET=SPRING
4, 14, 24
*ELEMENT, TYPE=MASS, ELSET=MASS
5, 5
*ELEMENT, TYPE=ROTARYI, ELSET=ROTARY
6, 5
*ORIENTATION, NAME=AXES, SYSTEM=CYLINDRICAL
0., 0., 0., 0., 0., 1.
3, 30.
*SOLID SECTION, ELSET=SOLID, MATERIAL=STEEL
*SHELL SECTION, ELSET=SKIN, COMPOSITE, ORIENTATION=AXES, OFFSET=SPOS
0.01, 3, STEEL, 0.
0.02, 3, STEEL, 90.
*BEAM SECTION, ELSET=BEAM, MATERIAL=STEEL, SECTION=I
0.1, 0.2, 0.1, 0.1, 0.01, 0.01, 0.02
0., 1., 0.
*SPRING, ELSET=SPRING, NONLINEAR

-10., -1.
10., 1.
*MASS, ELSET=MASS
2.
*ROTARY INERTIA, ELSET=ROTARY
1., 2., 3.
*NSET, NSET=TOP, GENERATE
21, 24
*SURFACE, NAME=UPPER
SOLID, S2
*SURFACE, NAME=LOWER
SKIN, SNEG
*TRANSFORM, NSET=TOP, TYPE=C
0., 0., 0., 0., 0., 1.
*EQUATION
2
TOP, 1, 1., 12, 2, -1.
*MPC
BEAM, 13, 23
*TIE, NAME=TIE, POSITION TOLERANCE=2.
LOWER, UPPER
*COUPLING, REF NODE=5, SURFACE=UPPER, CONSTRAINT NAME=HUB
*KINEMATIC
1, 3
*COUPLING, REF NODE=6, SURFACE=LOWER, CONSTRAINT NAME=MEAN
*DISTRIBUTING
*BOUNDARY
1, ENCASTRE
2, 1, 3
*STEP
*STATIC
*BOUNDARY
3, 1, 3, 0.
*END STEP
"""
)
_MADE_INP = (
    "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 0., 1., 0.\n4, 0., 0., 1.\n5, .5, 0., 0.\n6, .25, 0., 0.\n"
    "*NSET, NSET=N\n1, 2, 3, 4\n*NCOPY, CHANGE NUMBER=10, OLD SET=N, NEW SET=M, REFLECT=MIRROR\n"
    "0., 0., 0., 0., 1., 0.\n0., 0., 1.\n*NCOPY, CHANGE NUMBER=20, OLD SET=N, POLE\n1\n"
    "*ELEMENT, TYPE=C3D4, ELSET=E\n1, 1, 2, 3, 4\n*ELSET, ELSET=OLD\n1\n"
    "*ELCOPY, ELEMENT SHIFT=10, OLD SET=OLD, SHIFT NODES=10, NEW SET=E, REFLECT\n"
    "*ELEMENT, TYPE=B31, ELSET=B\n31, 1, 5\n32, 5, 2\n"
    "*BEAM SECTION, ELSET=B, MATERIAL=STEEL, SECTION=RECT\n.1, .2\n0., 1., 0.\n"
    "*RELEASE\nB, S1, M1-T, S2, ALLM\n*MPC\nLINEAR, 6, 1, 5\nQUADRATIC, 6, 1, 2, 5\nSLIDER, 5, 1, 2\n"
    "*DISTRIBUTION, NAME=D, LOCATION=ELEMENT\n, 1., 0., 0., 0., 1., 0.\n11, 0., 0., 1., 1., 0., 0.\n"
    "*ORIENTATION, NAME=O\nD\n3, 30.\n*SOLID SECTION, ELSET=E, MATERIAL=STEEL, ORIENTATION=O\n" + _STEEL_INP
)
_TWO_INP = (
    "*PART, NAME=P\n"
    + _INP
    + "*SHELL SECTION, ELSET=QUADS, MATERIAL=STEEL\n0.01\n*END PART\n*ASSEMBLY, NAME=A\n"
    + "*INSTANCE, NAME=A, PART=P\n*END INSTANCE\n*INSTANCE, NAME=B, PART=P\n0., 0., 1.\n"
    + "0., 0., 0., 1., 0., 0., 90.\n*END INSTANCE\n*NODE\n1, 0., 0., 5.\n*NSET, NSET=R\n1\n"
    + "*RIGID BODY, REF NODE=R, TIE NSET=B.ALL\n*END ASSEMBLY\n"
    + _STEEL_INP
)

_VTU = """\
<?xml version="1.0"?>
<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian">
<UnstructuredGrid><Piece NumberOfPoints="4" NumberOfCells="1"><Points>
<DataArray type="Float64" NumberOfComponents="3" format="ascii">0 0 0 1 0 0 0 1 0 0 0 1</DataArray></Points>
<Cells><DataArray type="Int32" Name="connectivity" format="binary">EAAAAAAAAAABAAAAAgAAAAMAAAA=</DataArray>
<DataArray type="Int32" Name="offsets" format="ascii">4</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">10</DataArray></Cells>
<PointData><DataArray type="Int8" Name="root" format="ascii">1 0 0 1</DataArray></PointData>
</Piece></UnstructuredGrid></VTKFile>
"""


def _meshes() -> Iterator[Kind]:
    def abaqus(path: Path) -> None:
        sp.read_abaqus(path)
        read_nodes(path)

    def nastran(path: Path) -> None:
        read_nodes(path)
        read_deck(path)
        sp.read_nastran(path)

    tail = b"*INCLUDE, INPUT=sets.inc\n"
    yield Kind(
        "Abaqus",
        abaqus,
        (
            Seed("mesh.inp", _INP.encode()),
            Seed("mesh.inp", _INP.encode() + tail, {"sets.inc": b"*NSET, NSET=MORE\n1, 2\n"}),
        ),
    )
    yield Kind("Nastran", nastran, (Seed("mesh.bdf", _BDF.encode()), Seed("mesh.bdf", _SOLID_BDF.encode())))
    yield Kind(
        "Nastran deck",
        read_deck,
        (Seed("deck.bdf", _DECK_BDF.encode()), Seed("parts.bdf", _PARTS_BDF.encode())),
    )
    yield Kind(
        "Abaqus deck",
        read_deck,
        (
            Seed("deck.inp", _DECK_INP.encode()),
            Seed("two.inp", _TWO_INP.encode()),
            Seed("made.inp", _MADE_INP.encode()),
        ),
    )
    folder = REPOSITORY / "tests" / "importers" / "gmsh_square"
    squares = tuple(Seed("mesh.msh", path.read_bytes()) for path in sorted(folder.glob("*.msh")))
    yield Kind("Gmsh", sp.read_gmsh, squares)
    yield Kind("VTU", read_vtu, (Seed("mesh.vtu", _VTU.encode()),))
    with netcdf_file(packed := io.BytesIO(), "w") as file:
        file.createDimension("three", 3)
        file.createDimension("nodes", 4)
        file.createDimension("one", 1)
        for name, code, dimensions, values in (
            ("coord", "d", ("three", "nodes"), np.eye(4)[1:]),
            ("connect1", "i", ("one", "nodes"), [[1, 2, 3, 4]]),
            ("eb_prop1", "i", ("one",), [7]),
            ("ns_prop1", "i", ("one",), [3]),
            ("node_ns1", "i", ("one",), [2]),
        ):
            file.createVariable(name, code, dimensions)[:] = values
        file.variables["connect1"].elem_type = "TETRA"
        file.flush()
        exodus = packed.getvalue()
    yield Kind("Exodus", read_exodus, (Seed("mesh.exo", exodus),))


def _matrices(folder: Path) -> Iterator[Kind]:
    nodes = Seed("nodes.inp", b"*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n")

    def both(path: Path) -> None:
        table = read_nodes(folder / nodes.name)
        for role in (MatrixRole.STIFFNESS, MatrixRole.MASS):
            read_labelled_matrix(path, role, table)

    def one(path: Path) -> None:
        read_labelled_matrix(path, MatrixRole.STIFFNESS, read_nodes(folder / nodes.name))

    def hdf5(path: Path) -> None:
        read_nodes(path)
        both(path)

    (folder / nodes.name).write_bytes(nodes.content)
    yield Kind("DMIG", both, (Seed("k.pch", _DMIG.encode()),))
    yield Kind("Abaqus matrix", one, (Seed("k.mtx", b"1,1,1,1,2.0\n1,2,1,1,-1.0\n1,2,1,2,2.0\n"),))
    dof, sti = b"1.1\n1.2\n2.1\n", b"1 1 2.0\n2 1 -1.0\n2 2 2.0\n3 3 1.0\n"
    yield Kind("CalculiX matrix", one, (Seed("k.sti", sti, {"k.dof": dof}),))
    yield Kind(
        "CalculiX freedoms", lambda path: one(path.with_suffix(".sti")), (Seed("k.dof", dof, {"k.sti": sti}),)
    )
    sparse = (
        b"%%MatrixMarket matrix coordinate real symmetric\n% said\n3 3 4\n1 1 2\n2 1 -1\n2 2 2\n3 3 1e3\n"
    )
    dense = b"%%MatrixMarket matrix array real general\n2 3\n1\n2\n3\n4\n5\n6.5\n"
    yield Kind("Matrix Market", read_matrix, (Seed("m.mtx", sparse), Seed("m.mtx", dense)))
    path = folder / "matrices.h5"
    with h5py.File(path, "w") as file:
        file["nodes"], file["node_ids"] = np.eye(2, 3), np.array([1, 2])
        file["freedoms"] = np.array([[1, 1], [1, 2], [2, 1]])
        file["node_sets/tip"] = np.array([2])
        for name in ("stiffness", "mass"):
            matrix = csc_array(np.diag([2.0, 3.0, 4.0]))
            for part in ("data", "indices", "indptr"):
                file[f"{name}/{part}"] = getattr(matrix, part)
    yield Kind("HDF5 matrices", hdf5, (Seed("m.h5", path.read_bytes()),), is_hdf5=True)
    try:
        from pyyeti.nastran import op4
    except ImportError:
        return
    matrices, seeds = {"KGG": np.eye(12), "MGG": 2 * np.eye(12)}, []
    for binary in (True, False):
        op4.write(str(folder / "k.op4"), matrices, binary=binary)
        seeds.append(Seed("k.op4", (folder / "k.op4").read_bytes()))
    yield Kind("OUTPUT4", both, tuple(seeds))


def _tables() -> Iterator[Kind]:
    yield Kind("time table", read_time_table, (Seed("law.csv", b"# s, N\n0,0\n0.5,1e3\n1.0,-2.5\n"),))
    polar = b"alpha_deg,cl,cd,cm\n-180,0,0.1,0\n-10,-0.5,0.02,0\n10,1.0,0.02,0\n180,0,0.1,0\n"
    yield Kind("polar", lambda path: read_polar(path, name="p"), (Seed("p.csv", polar),))
    rotor = b"radius_m,chord_m,twist_deg,polar\n2,1.2,10,p\n10,1.0,3,p\n20,0.5,0,p\n"
    yield Kind(
        "rotor",
        lambda path: read_rotor(path, polars=path.parent, n_blades=3),
        (Seed("r.csv", rotor, {"p.csv": polar}),),
    )
    stations = b"span_m,section,chord_m,twist_deg,pitch_axis_x_over_c\n0,s,2,9,0.5\n10,s,1,0,0.4\n"
    section = b"x_over_c,y_over_c\n1,0\n0.5,0.1\n0,0\n0.5,-0.1\n1,0\n"
    yield Kind(
        "stations",
        lambda path: read_stations(path, sections=path.parent),
        (Seed("b.csv", stations, {"s.csv": section}),),
    )
    folder = REPOSITORY / "tests" / "importers" / "turbine" / "windio_blade"
    yield Kind(
        "windIO",
        read_windio_blade,
        tuple(Seed("b.yaml", path.read_bytes()) for path in sorted(folder.glob("*.yaml"))),
    )


_CASE = """\
title = "square [plate] on a hinge"
gravity = [0, 0, -9.81]
units = { length = "m" }

[[body]]
name = "plate"
mesh = "mesh.inp"
shell = { thickness = 0.01, youngs_modulus = 2.1e11, poissons_ratio = 0.0, density = 7850.0 }
frame = { kind = "mean-axis" }
reduction = { basis = "craig-bampton", modes = 4, derivatives = { kind = "compressed", number = 3 } }
damping = { kind = "rayleigh-ratio", ratio = 0.02, modes = [1, 2] }

[[body.interface]]
name = "root"
nodes = "ROOT"

[[body]]
name = "hub"
position = [0, 0, 1]
[body.rigid]
mass = 2.5
inertia = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
[[body.interface]]
name = "centre"
position = [0.0, 0.0, 0.0]

[[joint]]
kind = "prescribed-rotation"
first = "ground"
second = "hub.centre"
axis = [0, 0, 1]
law = { kind = "table", file = "law.csv" }

[[joint]]
kind = "revolute"
first = "hub.centre"
second = "plate.root"
axis = [0, 1, 0]

[[spring]]
kind = "torsion"
first = "ground"
second = "hub.centre"
axis = [0, 0, 1]
stiffness = 10.0

[[load]]
kind = "force"
at = "plate.TIP"
vector = [0, 0, 1]
law = { kind = "sine", amplitude = 2.0, frequency_hz = 3.0 }

[simulation]
duration = 0.5
output_step = 0.1
adaptive = { first = 1e-4, largest = 1e-2 }
rho_inf = 0.8

[output]
track = ["plate.TIP", "hub.centre"]
pictures = false
"""
_RIGID = (
    """\
title = "two rods"
gravity = [0.0, -9.81, 0.0]
"""
    + "".join(
        f"""
[[body]]
name = "{name}"
position = [{x}, 0.0, 0.0]
rigid = {{ mass = 1.0, centre = [0.5, 0.0, 0.0], inertia = [[0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]] }}
interface = [{{ name = "a", position = [0, 0, 0] }}, {{ name = "b", position = [1, 0, 0] }}]
"""
        for name, x in (("upper", "0.0"), ("lower", "1.0"))
    )
    + """
[[joint]]
kind = "revolute"
first = "ground"
second = "upper.a"
axis = [0, 0, 1]
[[joint]]
kind = "ball"
first = "upper.b"
second = "lower.a"
[[load]]
kind = "torque"
at = "lower.b"
vector = [0, 0, 0.1]
law = { kind = "ramp", value = 1.0, duration = 0.1 }
[simulation]
duration = 0.02
output_step = 0.01
step = 0.01
"""
)


def _cases() -> Iterator[Kind]:
    def flexible(path: Path) -> None:
        case = read_case(path)
        _ = case.run.times, case.sources

    def rigid(path: Path) -> None:
        case = read_case(path)
        if not any(body.elastic for body in case.tables.body):
            _ = case.system

    beside = {"mesh.inp": _INP.encode(), "law.csv": b"0,0\n0.25,0.5\n0.5,1.0\n"}
    yield Kind("case", flexible, (Seed("case.toml", _CASE.encode(), beside),))
    yield Kind("rigid case", rigid, (Seed("case.toml", _RIGID.encode()),))


def _results(folder: Path) -> Iterator[Kind]:
    def result(path: Path) -> None:
        # Both ways of reading are tried, even if the first rejects the file.
        refusals = []
        for read in (lambda path: list(describe_result(path)), read_last_instant, read_sound_part):
            try:
                read(path)
            except SuppleError as refusal:
                refusals.append(refusal)
        if refusals:
            raise refusals[0]

    def cut_off(path: Path) -> None:
        header = read_header(path)
        ResultFile.resume(path, case=header.case, inputs=header.inputs).close()

    def reduced(path: Path) -> None:
        if holds_reduced_body(path):
            read_interface_names(path)
            sp.read_reduced_body(path)

    # In a process of its own: readers are forked from this one, which must not have computed with JAX.
    maker = mp.get_context("fork").Process(target=_make_results, args=(folder,))
    maker.start()
    maker.join()
    yield Kind("result file", result, (Seed("run.h5", (folder / "run.h5").read_bytes()),), is_hdf5=True)
    begun = Seed("run.h5", (folder / "begun.h5").read_bytes())
    yield Kind("cut-off run", cut_off, (begun,), is_hdf5=True)
    sealed = (folder / "beam.h5").read_bytes()
    with h5py.File(folder / "beam.h5", "r", driver="core", backing_store=False) as file:
        bare = file.id.get_file_image()
    yield Kind("reduced body", reduced, (Seed("beam.h5", sealed), Seed("beam.h5", bare)), is_hdf5=True)


def _make_results(folder: Path) -> None:
    """A result file, the result file of an interrupted run, and the file of a reduced body."""
    (folder / "case.toml").write_text(_RIGID, encoding="utf-8")
    case = read_case(folder / "case.toml")
    whole = folder / "run.h5"
    solution = simulate_recorded(case.system, case.run, whole, case=case.text)
    with ResultFile.create(folder / "begun.h5", case=case.text, inputs=read_header(whole).inputs) as begun:
        begun.append(solution.at(slice(0, 1)))
        begun.append(solution.at(slice(1, 2)))
    ends = [sp.RigidInterface("root", "root")]
    steel = sp.Isotropic(2e11, 0.3, 7800.0)
    model = sp.solid_model(sp.block(1.0, 0.1, 0.1, 2, 1, 1, sp.CellType.TETRA4), steel)
    flexible = sp.flexible_body("beam", model, ends)
    derivatives = sp.CompressedDerivatives(1)
    body = sp.reduce(flexible, sp.MeanAxisFrame(), sp.CraigBampton(n_modes=2), derivatives=derivatives)
    sp.write_reduced_body(folder / "beam.h5", body)
