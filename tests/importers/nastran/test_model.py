"""Nastran models: what is read, and the file, line, card and remedy of everything that is not."""

from __future__ import annotations

import meshio
import numpy as np
import pytest

from supple.errors import ImportFormatError, MeshError
from supple.importers import (
    BeamProperty,
    ElasticMaterial,
    ShellProperty,
    SolidProperty,
    UnusedNodes,
    read_mesh,
    read_nastran,
    read_nodes,
)
from supple.mesh import CellType, block, strip

SQUARE = """\
GRID,10,,0.,0.,0.
GRID,20,,1.,0.,0.
GRID,30,,1.,1.,0.
GRID,40,,0.,1.,0.
CTRIA3,1,7,10,20,30
CTRIA3,2,7,10,30,40
PSHELL,7,5,0.1,5
MAT1,5,2.1+11,,.3,7850.
"""
TETRA = """\
GRID,1,,0.,0.,0.
GRID,2,,1.,0.,0.
GRID,3,,0.,1.,0.
GRID,4,,0.,0.,1.
CTETRA,1,3,1,2,3,4
PSOLID,3,5
MAT1,5,2.1+11,,.3,7850.
"""


@pytest.fixture
def read(tmp_path):
    def read_text(text, **options):
        path = tmp_path / "model.bdf"
        path.write_text(text)
        return read_nastran(path, **options)

    return read_text


# --- what is read


@pytest.mark.parametrize("kind", [kind for kind in CellType if kind.n_corners in (4, 8)])
def test_solids_in_all_their_node_orders(read, bulk, kind):
    """A wrong order of middle nodes would be an inverted cell, or another one."""
    mesh = block(2.0, 1.0, 1.0, 2, 1, 1, kind)
    model = read(bulk.text(mesh, *bulk.solid()))
    np.testing.assert_array_equal(model.mesh.nodes, mesh.nodes)
    np.testing.assert_array_equal(model.mesh.cells[kind], mesh.cells[kind])
    assert model.properties == {"psolid_1": SolidProperty(ElasticMaterial(2.1e11, 0.3, 7850.0))}
    np.testing.assert_array_equal(model.node_ids, 1 + np.arange(mesh.n_nodes))


@pytest.mark.parametrize(
    "kind", [CellType.TRIANGLE3, *(kind for kind in CellType if kind.n_corners in (4, 8))]
)
def test_meshes_written_by_another_program(tmp_path, kind):
    """meshio writes in its own fields and node orders; property cards are added for it."""
    mesh = strip(2.0, 1.0, 2, 2) if kind is CellType.TRIANGLE3 else block(2.0, 1.0, 1.0, 2, 1, 1, kind)
    cells = [(kind.meshio_name, mesh.cells[kind])]
    groups = {"nastran:ref": [np.ones(len(mesh.cells[kind]), dtype=int)]}
    path = tmp_path / "other.bdf"
    meshio.write(path, meshio.Mesh(mesh.nodes, cells, cell_data=groups))
    of = "PSHELL,1,5,.1,5" if kind is CellType.TRIANGLE3 else "PSOLID,1,5"
    # It marks quadratic elements as CTETRA_ and CHEXA_, which Nastran does not know.
    text = path.read_text().replace("CTETRA_", "CTETRA ").replace("CHEXA_", "CHEXA ")
    path.write_text(text.replace("ENDDATA", f"{of}\nMAT1,5,1.,,.3,1.\nENDDATA"))
    again = read_nastran(path).mesh
    np.testing.assert_allclose(again.nodes, mesh.nodes, atol=1e-12)
    np.testing.assert_array_equal(again.cells[kind], mesh.cells[kind])


def test_ids_become_numbers_in_the_order_of_the_file(read):
    model = read(SQUARE)
    np.testing.assert_array_equal(model.node_ids, [10, 20, 30, 40])
    np.testing.assert_array_equal(model.mesh.cells[CellType.TRIANGLE3], [[0, 1, 2], [0, 2, 3]])
    assert model.properties == {"pshell_7": ShellProperty(ElasticMaterial(2.1e11, 0.3, 7850.0), 0.1)}


def test_quadrilaterals_become_triangles_each_in_the_set_of_its_property(read):
    text = SQUARE.replace(
        "CTRIA3,2,7,10,30,40\n", "GRID,50,,2.,0.,0.\nGRID,60,,2.,1.,0.\nCQUAD4,2,8,20,50,60,30\n"
    )
    mesh = read(text.replace("CTRIA3,1,7,10,20,30", "CQUAD4,1,7,10,20,30,40") + "PSHELL,8,5,.2,5\n").mesh
    assert len(mesh.cells[CellType.TRIANGLE3]) == 4
    np.testing.assert_array_equal(mesh.cells_of("pshell_7")[CellType.TRIANGLE3], [0, 1])
    np.testing.assert_array_equal(mesh.cells_of("pshell_8")[CellType.TRIANGLE3], [2, 3])


def test_both_kinds_of_triangle_cards_share_a_property(read):
    text = SQUARE + "GRID,50,,2.,0.,0.\nGRID,60,,2.,1.,0.\nCQUAD4,3,7,20,50,60,30\n"
    mesh = read(text).mesh
    np.testing.assert_array_equal(mesh.cells_of("pshell_7")[CellType.TRIANGLE3], [0, 1, 2, 3])


def test_the_mesh_of_one_property(tmp_path):
    text = SQUARE + "PSHELL,8,5,.2,5\nGRID,50,,2.,0.,0.\nCTRIA3,3,8,20,50,30\n"
    (tmp_path / "model.nas").write_text(text)
    mesh = read_mesh(tmp_path / "model.nas", only="pshell_8")
    np.testing.assert_array_equal(mesh.nodes, [[1, 0, 0], [1, 1, 0], [2, 0, 0]])


def test_loads_and_solution_cards_are_passed_over(read):
    assert read(SQUARE + "FORCE,1,10,,1.,0.,0.,1.\nEIGRL,9,,,10\nPARAM,AUTOSPC,YES\n").mesh.n_cells == 2


def test_supports_and_the_analysis_set_are_node_sets(read):
    text = SQUARE.replace("GRID,40,,0.,1.,0.", "GRID,40,,0.,1.,0.,,3")
    text += "SPC1,1,123456,10,20\nSPC,2,30,21,0.,40,12,0.\nSPC1,1,123456,30,THRU,45\n"
    text += "ASET1,123,10,THRU,20\nASET,40,4\n"
    sets = {name: members.tolist() for name, members in read(text).mesh.node_sets.items()}
    assert sets == {"spc_3": [3], "spc2_12": [2, 3], "spc1_123456": [0, 1, 2, 3], "aset": [0, 1, 3]}


def test_the_freedoms_of_an_analysis_set_are_sorted_as_nastran_does(tmp_path):
    (tmp_path / "model.bdf").write_text(SQUARE + "ASET1,31,30,10\nASET,20,4\n")
    retained = read_nodes(tmp_path / "model.bdf").retained
    assert retained is not None
    assert retained.tolist() == [[10, 1], [10, 3], [20, 4], [30, 1], [30, 3]]


def test_connections_have_their_reference_grid_as_position(read):
    text = SQUARE + "GRID,90,,5.,0.,0.\nRBE2,70,90,123456,20,30\n"
    text += "GRID,91,,-1.,0.,0.\nRBE3,71,,91,123456,1.0,123,10\n,40,3.,123,20,ALPHA,6.5-6\n"
    text += "RBE2,72,10,123456,40,6.5-6\n"
    model = read(text)
    np.testing.assert_array_equal(model.node_ids, [10, 20, 30, 40])  # references are places, not nodes
    rigid, own, averaging = sorted(model.connections, key=lambda c: (c.weights is not None, c.name))
    assert (rigid.name, own.name, averaging.name) == ("rbe2_70", "rbe2_72", "rbe3_71")
    np.testing.assert_array_equal(rigid.nodes, [1, 2])
    np.testing.assert_array_equal(rigid.position, [5, 0, 0])
    np.testing.assert_array_equal(
        own.nodes, [0, 3]
    )  # elements use its reference, which moves with the others
    np.testing.assert_array_equal(averaging.nodes, [0, 3, 1])
    np.testing.assert_array_equal(averaging.weights, [1, 1, 3])
    np.testing.assert_array_equal(model.mesh.nodes_of("rbe3_71"), [0, 3, 1])


def test_rotations_of_solids_may_stand_in_a_connection_or_not(read):
    for components in ("123", "123456"):
        model = read(
            TETRA + f"GRID,9\nRBE2,5,9,{components},1,2,3\nGRID,8\nRBE3,6,,8,123,1.,{components},1,2\n,3\n"
        )
        assert [len(connection.nodes) for connection in model.connections] == [3, 3]


def test_mass_in_units_of_weight_and_mass_without_strength(read):
    text = SQUARE.replace("0.1,5", "0.1,5,,,,2.0")
    for given in (
        text + "PARAM,WTMASS,.01\n",
        f"SOL 103\nCEND\nPARAM,WTMASS,.01\nBEGIN BULK\n{text}ENDDATA\n",
    ):
        shell = read(given).properties["pshell_7"]
        assert shell.material.density == pytest.approx(0.01 * (7850 + 2.0 / 0.1))


@pytest.mark.parametrize(
    "given", ["2.1+11,,.3", ",8.0769231+10,.3", "2.1+11,8.0769231+10", "2.1+11,8.08+10,.3"]
)
def test_two_moduli_are_enough(read, given):
    material = (
        read(TETRA.replace("2.1+11,,.3", given + "," * (2 - given.count(","))))
        .properties["psolid_3"]
        .material
    )
    assert material.youngs_modulus == pytest.approx(2.1e11, rel=1e-6)
    assert material.poissons_ratio == pytest.approx(0.3, abs=1e-6)


def test_unused_grids_can_be_dropped(read):
    model = read("GRID,5,,9.,9.,9.\n" + SQUARE + "SPC1,1,123,5\n", unused_nodes=UnusedNodes.DROP)
    np.testing.assert_array_equal(model.node_ids, [10, 20, 30, 40])
    np.testing.assert_array_equal(model.mesh.cells[CellType.TRIANGLE3], [[0, 1, 2], [0, 2, 3]])
    assert not model.mesh.node_sets


def test_nodes_for_matrices_stand_beside_elements_of_any_kind(tmp_path):
    text = SQUARE + "CBUSH,9,3,10,20\nCONM2,12,,30,5.\nGRID,90,,5.,0.,0.\nRBE3,70,,90,123456,1.,123,20,30\n"
    (tmp_path / "model.bdf").write_text(text)
    table = read_nodes(tmp_path / "model.bdf")
    np.testing.assert_array_equal(table.ids, [10, 20, 30, 40, 90])
    np.testing.assert_array_equal(table.node_sets["rbe3_70"], [1, 2])
    assert table.axes is None


BEAMS = """\
CORD2C,1,,0.,0.,0.,0.,0.,1.
,1.,0.,0.
GRID,1,1,2.,90.,0.,1
GRID,2,,4.,2.,0.
GRID,3,,4.,2.,3.
GRID,9,,0.,0.,7.
CBAR,1,4,1,2,-1.,0.,0.
CBAR,2,4,2,3,0.,1.,0.
CBAR,3,4,2,3,9
PBAR,4,5,.01,2.-5,1.-5,3.-5,6.
,,,,,,,,
,.8,.7
MAT1,5,2.1+11,,.3,7850.
"""


def test_beams_have_one_cell_set_for_each_direction_of_their_section(read):
    model = read(BEAMS)  # grid 9 only shows a direction
    assert list(model.properties) == ["pbar_4", "pbar_4_2", "pbar_4_3"]
    np.testing.assert_array_equal(model.mesh.cells_of("pbar_4_2")[CellType.LINE2], [1])
    first, second, third = (model.properties[name] for name in model.properties)
    assert isinstance(first, BeamProperty)
    assert (first.area, first.I1, first.I2, first.J, first.K1, first.K2) == (0.01, 2e-5, 1e-5, 3e-5, 0.8, 0.7)
    assert first.mass_per_length == pytest.approx(7850 * 0.01 + 6.0)
    # In the cylindrical axes of grid 1, at (0, 2, 0), -r is -y.
    assert first.orientation == (0, -1, 0)
    assert second.orientation == (0, 1, 0)
    np.testing.assert_allclose(third.orientation, np.array([-4, -2, 7]) / np.sqrt(69), atol=1e-12)


def beam(properties):
    return changed(BEAMS[BEAMS.index("PBAR") : BEAMS.index("MAT1")], properties, BEAMS).replace(
        "CBAR", "CBEAM"
    )


@pytest.mark.parametrize(
    ("properties", "expected"),
    [
        ("PBEAM,4,5,.01,2.-5,1.-5,0.,3.-5,6.\n", (0.01, 2e-5, 1e-5, 3e-5, 1.0, 1.0)),
        ("PBEAM,4,5,.01,2.-5,1.-5,0.,3.-5,6.\n,.1,.1,.1,.1\n,.5,.6\n", (0.01, 2e-5, 1e-5, 3e-5, 0.5, 0.6)),
        (
            "PBEAM,4,5,.01,2.-5,1.-5,0.,3.-5,6.\n,YES,1.0,.01,2.-5,,,,6.\n,.1,.1\n,.5,.6,0.,0.\n",
            (0.01, 2e-5, 1e-5, 3e-5, 0.5, 0.6),
        ),
        (
            "PBEAML,4,5,,ROD\n,.1,6.\n",
            (np.pi * 0.01, np.pi * 1e-4 / 4, np.pi * 1e-4 / 4, np.pi * 1e-4 / 2, 0.9, 0.9),
        ),
        (
            "PBEAML,4,5,,TUBE\n,.1,.05\n",
            (
                np.pi * 0.0075,
                np.pi * (1e-4 - 6.25e-6) / 4,
                np.pi * (1e-4 - 6.25e-6) / 4,
                np.pi * (1e-4 - 6.25e-6) / 2,
                0.5,
                0.5,
            ),
        ),
        # A square of side a has J = 0.140577 a^4 [Timoshenko & Goodier, table 7].
        ("PBEAML,4,5,,BAR\n,.1,.1\n", (0.01, 1e-4 / 12, 1e-4 / 12, 0.140577e-4, 5 / 6, 5 / 6)),
    ],
)
def test_sections_of_beams(read, properties, expected):
    made = read(beam(properties)).properties.values()
    for section in made:
        assert isinstance(section, BeamProperty)
        values = (section.area, section.I1, section.I2, section.J, section.K1, section.K2)
        np.testing.assert_allclose(values, expected, rtol=5e-6)


# --- what is refused


def changed(old, new, text=SQUARE):
    assert old in text
    return text.replace(old, new)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (changed("10,30,40", "10,30,99"), r"line 6: CTRIA3: element 2 names grid 99.*add its GRID card"),
        (changed("CTRIA3,2,", "CTRIA3,1,"), "line 6: CTRIA3: element 1 is defined a second time; renumber"),
        (changed("GRID,40", "GRID,30"), "line 4: GRID: grid 30 is defined a second time and differs"),
        (SQUARE + "CBUSH,9,3,10,20\n", "line 9: CBUSH: this card is not read; make it a spring"),
        (SQUARE + "SPOINT,99\n", "line 9: SPOINT: this card is not read; remove it, or replace it"),
        (SQUARE + "PARAM,CM1,2.0\n", "line 9: PARAM: the factor CM1 is not read; scale the materials"),
        (SQUARE + "CONM2,9,10,,5.\n", "line 9: CONM2: this card is not read; make it a rigid body"),
        ("GRID,9\n" + SQUARE, r"line 1: GRID: grid 9 \(one of 1\) is used by no element.*UnusedNodes.DROP"),
        (
            changed("CTRIA3,1,7", "CTRIA3,1,8"),
            "line 5: CTRIA3: element 1 names property 8, which the file does not",
        ),
        (
            changed("CTRIA3,1,7", "CTRIA3,1,8") + "PSOLID,8,5\n",
            "line 5: .*property 8, which is a PSOLID; add PSHELL 8",
        ),
        (SQUARE + "PSHELL,7,5,.1,5\n", "line 9: PSHELL: property 7 is defined a second time"),
        (
            changed("10,20,30\n", "10,20,30,,.05\n"),
            "line 5: CTRIA3: an offset ZOFFS is not read; write the element without",
        ),
        (
            changed("10,20,30\n", "10,20,30\n,,,.2\n"),
            "line 5: CTRIA3: T1 is not read; write the element without",
        ),
        (changed("10,20,30\n", "10,20,30\n,,,,,.2\n"), "line 5: CTRIA3: T3 is not read"),
        (
            changed("CTRIA3,1,7,10,20,30", "CQUAD4,1,7,10,20,30,40\n,,,,,,.2"),
            "line 5: CQUAD4: T4 is not read; write the element without",
        ),
        (
            changed("CTRIA3,1,7,10,20,30", "CQUAD4,1,7,10,30,20,40"),
            "line 5: CQUAD4: element 1: its sides cross.*list them in their order around it",
        ),
        (
            changed("CTETRA,1,3,1,2,3,4", "CTETRA,1,3,1,2,3,4,2", TETRA),
            "line 5: CTETRA: element 1 names 5 grids; it takes",
        ),
        ("GRID,1\n", r"model\.bdf: no element \(CTETRA, CHEXA"),
    ],
)
def test_elements_that_are_wrong(read, text, message):
    with pytest.raises(ImportFormatError, match=message):
        read(text)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (changed("MAT1,5", "MAT1,6"), "line 7: PSHELL: names material 5, which no MAT1 defines; add it"),
        (SQUARE + "MAT1,5,1.,,.3,1.\n", "line 9: MAT1: material 5 is defined a second time"),
        (changed(",7850.", ""), "line 8: MAT1: no density; a moving body needs mass, so give RHO"),
        (changed("2.1+11,,.3", ",,.3"), "line 8: MAT1: E is missing or not positive"),
        (changed("2.1+11,,.3", "2.1+11,,"), "line 8: MAT1: NU and G are both missing, and Nastran would"),
        (
            changed("2.1+11,,.3", "2.1+11,7.+10,.3"),
            "line 8: MAT1: G = 7e.10 does not fit E = 2.1e.11 and NU = 0.3",
        ),
        (changed("2.1+11,,.3", "2.1+11,,.5"), "line 8: MAT1: Poisson's ratio is 0.5; it lies"),
        (
            changed("7,5,0.1,5", "7,5,0.1"),
            "line 7: PSHELL: the bending material MID2 is blank, the membrane's is 5",
        ),
        (changed("7,5,0.1,5", "7,5,0.1,5,2.0"), r"line 7: PSHELL: 12 I/T\^3 is 2.0; only homogeneous"),
        (changed("7,5,0.1,5", "7,5,0.1,5,,,,\n,,,5"), "line 7: PSHELL: a coupling material MID4 is not read"),
        (changed("7,5,0.1,5", "7,5,-.1,5"), "line 7: PSHELL: the thickness T is -0.1; it must be positive"),
        (
            changed("PSOLID,3,5", "PSOLID,3,5,4", TETRA),
            r"line 6: PSOLID: a material coordinate system \(CORDM\)",
        ),
        (
            changed("PSOLID,3,5", "PSOLID,3,5,,,,,PFLUID", TETRA),
            r"line 6: PSOLID: FCTN is PFLUID, a fluid; only structure \(SMECH\) is read",
        ),
        (TETRA + "PARAM,WTMASS,0.\n", "line 8: PARAM: WTMASS is 0; it must be positive"),
        (
            TETRA + "PARAM,WTMASS,1.\nPARAM,WTMASS,.01\n",
            "line 9: PARAM: WTMASS is 0.01, and 1 above; keep one of the two",
        ),
    ],
)
def test_properties_that_our_elements_do_not_have(read, text, message):
    with pytest.raises(ImportFormatError, match=message):
        read(text)


@pytest.mark.parametrize(
    ("card", "message"),
    [
        ("SPC1,1,127,10", "line 9: SPC1: components '127' are not some of 123456"),
        ("SPC1,1,123,99", "line 9: SPC1: names grid 99, which the file does not define"),
        ("SPC1,1,123,10,THRU,20,40", "line 9: SPC1: '40' follows 10 THRU 20; write it on a card of its own"),
        ("ASET1,123,10,THRU,40,EXCEPT,20", "line 9: ASET1: 'EXCEPT' follows 10 THRU 40"),
        ("SPC1,1,123,50,THRU,60", "line 9: SPC1: no grid lies in 50 THRU 60; correct the range"),
        ("SPC1,1,123", "line 9: SPC1: names no grids; add them, or is the file cut short"),
        ("ASET", "line 9: ASET: names no grids"),
        ("SPC,1,10,3,0.5", "line 9: SPC: an enforced displacement is not read; prescribe it by a joint"),
        (
            "RBE2,5,10,123,20",
            "line 9: RBE2: ties the components '123'; a rigid interface ties all, so write 123456",
        ),
        ("RBE2,5,10,123456,99", "line 9: RBE2: names grid 99, which the file does not define"),
        ("RBE2,5,10,123456,20,20", "line 9: RBE2: names grid 20 more than once"),
        ("GRID,90\nRBE2,5,90,123456", "line 10: RBE2: ties no grids; add them"),
        ("GRID,90\nGRID,91\nRBE2,5,90,123456,91,10", "line 11: RBE2: ties grid 91, which no element uses"),
        (2 * "RBE2,5,10,123456,20\n", "line 10: RBE2: element 5 is defined a second time"),
        ("RBE3,5,,10,123456,1.,123,20", "line 9: RBE3: elements use its reference grid 10"),
        (
            "GRID,90\nRBE3,5,,90,3,1.,123,20",
            "line 10: RBE3: its reference grid follows in the components '3'",
        ),
        (
            "GRID,90\nRBE3,5,,90,123456,1.,123456,20",
            "line 10: RBE3: averages the components '123456'.*write 123",
        ),
        ("GRID,90\nRBE3,5,,90,123456,-1.,123,20", "line 10: RBE3: a weight is -1; weights are positive"),
        ("GRID,90\nRBE3,5,,90,123456,10,20", "line 10: RBE3: '10' stands where a weight is expected"),
        (
            "GRID,90\nRBE3,5,,90,123456,1.,123,20,UM\n,10,1",
            r"line 10: RBE3: a choice of dependent freedoms \(UM\)",
        ),
    ],
)
def test_sets_and_connections_that_are_wrong(read, card, message):
    with pytest.raises(ImportFormatError, match=message):
        read(SQUARE + card + "\n")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            changed("2,-1.,0.,0.", "2,-1.,0.,0.,BGG", BEAMS),
            "line 7: CBAR: the flag OFFT is BGG; only GGG is read",
        ),
        (
            changed("2,-1.,0.,0.", "2,0.,-1.,0.", BEAMS),
            r"line 7: CBAR: its orientation .* or along the beam; give one",
        ),
        (changed("2,-1.,0.,0.", "2", BEAMS), "line 7: CBAR: its orientation .* is missing"),
        (changed("2,-1.,0.,0.", "2,-1.,0.,0.,,\n,56", BEAMS), "line 7: CBAR: a pin flag PA is not read"),
        (changed("2,-1.,0.,0.", "2,-1.,0.,0.,,\n,,,.1", BEAMS), "line 7: CBAR: an offset W1A is not read"),
        (
            changed(",.8,.7", ",.8,.7,1.-6", BEAMS),
            "line 10: PBAR: a product of inertia I12 is not read; turn",
        ),
        (changed("3.-5,6.", ",6.", BEAMS), "line 10: PBAR: J is 0; a beam of ours needs area, I1, I2 and J"),
        (beam("PBEAM,4,5,.01,2.-5,1.-5,1.-6,3.-5\n"), "line 10: PBEAM: a product of inertia I12"),
        (
            beam("PBEAM,4,5,.01,2.-5,1.-5,0.,3.-5\n,NO,1.,.02\n"),
            "line 10: PBEAM: a tapered section is not read",
        ),
        (
            beam("PBEAM,4,5,.01,2.-5,1.-5,0.,3.-5\n,.1\n,1.,1.,,,,,,\n,,,,,.02\n"),
            "PBEAM: shear relief, NSI, warping",
        ),
        (
            beam("PBEAML,4,5,,I\n,.1,.1\n"),
            "line 10: PBEAML: section I is not read; write PBAR or PBEAM, or one of ROD",
        ),
        (
            beam("PBEAML,4,5,,ROD\n,-.1\n"),
            r"line 10: PBEAML: sizes \[-0.1\] of section ROD; they must be positive",
        ),
        (beam("PBEAML,4,5,,ROD\n,.1,,YES,1.,.2\n"), "line 10: PBEAML: a tapered section is not read"),
        (
            BEAMS.replace("CBAR,1", "CBEAM,1"),
            "line 7: CBEAM: element 1 names property 4, which is a PBAR; add PBEAM or",
        ),
    ],
)
def test_beams_that_are_wrong(read, text, message):
    with pytest.raises(ImportFormatError, match=message):
        read(text)


def test_a_zero_volume_element_is_named_with_its_line(read):
    with pytest.raises(
        MeshError, match=r"model\.bdf, line 5: element 1: 1 degenerate TETRA4 cell.*move its nodes"
    ):
        read(changed("GRID,4,,0.,0.,1.", "GRID,4,,1.,1.,0.", TETRA))
    flat = changed("GRID,40,,0.,1.,0.", "GRID,40,,.5,.5,0.")
    with pytest.raises(MeshError, match=r"model\.bdf, line 6: element 2: 1 degenerate TRIANGLE3"):
        read(flat)
    twice = changed("10,30,40", "10,30,30")
    with pytest.raises(
        MeshError, match=r"model\.bdf, line 6: element 2: 1 TRIANGLE3 cell.*a node named twice"
    ):
        read(twice.replace("GRID,40,,0.,1.,0.\n", "$\n"))


def test_a_truncated_file_is_recognised(read, bulk):
    whole = bulk.text(block(1, 1, 1, 1, 1, 1, CellType.HEXA8), *bulk.solid())
    with pytest.raises(ImportFormatError, match=r"no element \(CTETRA.*is this a mesh file, and whole\?"):
        read(whole[: len(whole) // 2])
