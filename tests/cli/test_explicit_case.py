"""`supple run` of a case of parts: result, report, pictures, films; cut off and resumed; mistakes named."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from typer.testing import CliRunner

from supple.cases import read_case, run_case
from supple.cases.implausible_units import warn_of_units
from supple.cases.result_tables import recorded_quantities
from supple.cli.main import app
from supple.errors import CaseError, UnitsWarning
from supple.integrate import Solution, Statistics
from supple.machine import (
    EveryNode,
    MeanMotion,
    Mortar,
)
from supple.mesh import CellType, block
from supple.methods.explicit import (
    OBSTACLES,
    BulkViscosity,
)
from supple.quantities import read_sensors
from supple.storage import read_solution

CASE = """
title = "a bar against a wall"
units = { length = "m", mass = "kg", time = "s" }

[[body]]
name = "rest"
mesh = "bar.inp"
cells = "REST"
solid = { youngs_modulus = 70e9, poissons_ratio = 0.3, density = 2700.0 }
modal = { modes = 4 }
interface = [{ name = "JOINT", kind = "averaging", nodes = "JOINT" }]
damping = { kind = "linear-rayleigh", alpha = 10.0, beta = 0.0 }
velocity = [30.0, 0.0, 0.0]

[[body]]
name = "nose"
mesh = "bar.inp"
cells = "NOSE"
solid = { youngs_modulus = 70e9, poissons_ratio = 0.3, density = 2700.0 }
explicit = { law = { kind = "j2", yield_stress = 100e6, modulus = 300e6 } }
velocity = [30.0, 0.0, 0.0]

[[tie]]
nodes = "nose.JOINT"
on = "rest"

[[contact]]
nodes = "nose.TIP"
obstacle = { kind = "plane", point = [0.6, 0.0, 0.0], normal = [-1.0, 0.0, 0.0] }

[simulation]
duration = 2e-4
output_step = 2e-5

[output]
track = ["nose.JOINT"]
"""
PLAIN = ("[output]", "[output]\npictures = false\nanimation = false\nreport = false")


def solid_text(mesh, sets):
    """A mesh of hexahedra with cell sets, in the format of Abaqus."""
    (cells,) = mesh.cells.values()
    rows = ["*NODE", *(f"{i}, {x!r}, {y!r}, {z!r}" for i, (x, y, z) in enumerate(mesh.nodes.tolist(), 1))]
    for name, chosen in sets.items():
        rows.append(f"*ELEMENT, TYPE=C3D8, ELSET={name}")
        rows += [f"{e + 1}, " + ", ".join(str(n + 1) for n in cells[e]) for e in np.flatnonzero(chosen)]
    for name, at in (("JOINT", 0.4), ("TIP", 0.6)):
        rows += [
            f"*NSET, NSET={name}",
            ", ".join(str(n + 1) for n in np.flatnonzero(np.isclose(mesh.nodes[:, 0], at))),
        ]
    return "\n".join(rows) + "\n"


@pytest.fixture
def bar(tmp_path):
    """Writes `bar.toml`, changed as told, beside its mesh."""
    mesh = block(0.6, 0.1, 0.1, 6, 1, 1, CellType.HEXA8)
    middle = mesh.nodes[mesh.cells[CellType.HEXA8]].mean(axis=1)[:, 0]
    (tmp_path / "bar.inp").write_text(solid_text(mesh, {"REST": middle < 0.4, "NOSE": middle > 0.4}))

    def written(*changes):
        text = CASE
        for old, new in changes:
            assert old in text
            text = text.replace(old, new)
        (tmp_path / "bar.toml").write_text(text)
        return tmp_path / "bar.toml"

    return written


@pytest.mark.slow
def test_a_run_writes_its_motion_numbers_pictures_and_films(bar, tmp_path):
    folder = tmp_path / "out"
    result = CliRunner().invoke(app, ["run", str(bar()), "-o", str(folder)])
    assert result.exit_code == 0, result.output
    assert "Energies" in result.output
    assert "balance error" in result.output
    numbers = json.loads((folder / "bar.json").read_text())
    mass = 2700.0 * 0.6 * 0.1**2
    assert numbers["energies"]["kinetic"]["start"] == pytest.approx(0.5 * mass * 30.0**2, rel=1e-9)
    assert numbers["energies"]["plastic"]["end"] > 0.05 * numbers["energies"]["kinetic"]["start"]
    assert numbers["balance"]["relative"] < 1e-6
    assert numbers["bodies"]["nose"]["largest plastic strain"] > 1e-3
    written = {path.name for path in folder.iterdir()}
    assert {"bar.h5", "energies.png", "tracked-motion.png", "motion.gif"} <= written
    nose = read_solution(folder / "bar.h5").bodies["nose"]
    # Yielding metal stands at its yield stress, hardened.
    hardest = 100e6 + 300e6 * nose.plastic_strain.max()
    assert 100e6 < nose.von_mises.max() <= hardest * (1 + 1e-6)
    again = CliRunner().invoke(app, ["run", str(tmp_path / "bar.toml"), "-o", str(folder)])
    assert "--force replaces" in again.output


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::supple.errors.ValidityWarning")  # beyond the yield stress of the nose
def test_a_run_that_was_cut_off_is_resumed_to_the_last_bit(bar, tmp_path):
    path = bar(PLAIN)
    run_case(read_case(path), tmp_path / "whole")

    class CutError(Exception):
        pass

    def cut(_, share):
        if share > 0.5:
            raise CutError

    with pytest.raises(CutError):
        run_case(read_case(path), tmp_path / "cut", progress=cut)
    result = CliRunner().invoke(app, ["run", str(path), "-o", str(tmp_path / "cut"), "--resume"])
    assert result.exit_code == 0, result.output
    whole, resumed = (read_solution(tmp_path / name / "bar.h5") for name in ("whole", "cut"))
    for name, motion in whole.bodies.items():
        for field, values in motion.arrays().items():
            assert np.array_equal(values, resumed.bodies[name].arrays()[field]), (name, field)


def test_every_mistake_is_listed_with_its_line(bar):
    path = bar(
        ('nodes = "nose.JOINT"', 'nodes = "rest.JOINT"'),
        ('nodes = "nose.TIP"', 'nodes = "nos.TIP"\nsurface = "rest.JOINT"'),
        ("modulus = 300e6", "modulus = 300e6, factor = 1e8"),
    )
    with pytest.raises(CaseError) as caught:
        read_case(path)
    told = str(caught.value)
    assert "exactly one of obstacle, surface" in told
    assert "did you mean 'nose'" in told
    assert "needs factor and exponent" in told
    path = bar(('nodes = "nose.TIP"', 'nodes = "nose.TIP"\nstiffness = 1e6\nfraction = 0.1'))
    with pytest.raises(CaseError, match="so the fraction has no effect; remove one of the two"):
        read_case(path)
    path = bar(('nodes = "nose.JOINT"', 'nodes = "rest.JOINT"'), ('on = "rest"', 'on = "nose"'))
    with pytest.raises(CaseError, match="a modal part cannot be tied to an explicit one"):
        read_case(path)
    with pytest.raises(CaseError, match="cannot be tied to itself"):
        read_case(bar(('on = "rest"', 'on = "nose"')))
    every = 'on = "rest"\ncontinuity = { kind = "every-node" }'
    with pytest.raises(CaseError, match="explicit nodes are tied one by one"):
        read_case(bar(('on = "rest"', every)))


@pytest.mark.parametrize(
    "table",
    [
        '[[joint]]\nkind = "fixed"\nfirst = "ground"\nsecond = "nose.TIP"',
        '[[load]]\nkind = "force"\nfollower = true\nat = "nose.TIP"\nvector = [1.0, 0.0, 0.0]',
        '[[load]]\nkind = "torque"\nat = "nose.TIP"\nvector = [1.0, 0.0, 0.0]',
    ],
)
def test_what_needs_an_interface_of_explicit_elements_is_told_the_way_round(bar, table):
    """Not to add an interface, which explicit elements do not take."""
    with pytest.raises(CaseError, match=r"'nose' has explicit elements.*tie the nodes to a modal") as caught:
        read_case(bar(("[output]", f"{table}\n\n[output]")))
    assert "add one" not in str(caught.value)


def test_an_error_estimate_that_no_explicit_run_has_is_refused(bar):
    asked = ("[output]", "[error]\nintegration = false\nbasis = true\n\n[output]")
    with pytest.raises(
        CaseError, match=r"error.basis: the error of an explicit run is not estimated"
    ) as caught:
        read_case(bar(asked))
    assert "integration" not in str(caught.value)


def test_a_modal_part_stiffens_with_its_spin_where_the_file_says_so(bar):
    assert read_case(bar()).system.placed("rest").body.spin_stiffness is None
    spun = ("modes = 4", "modes = 4, spin_stiffness = true")
    body = read_case(bar(spun)).system.placed("rest").body
    assert body.spin_stiffness.shape == (6, body.n_modes, body.n_modes)


def test_a_part_has_the_yield_stress_and_the_viscosity_that_the_file_says(bar):
    system = read_case(bar()).system
    assert system.placed("rest").body.yield_stress is None
    assert system.placed("nose").body.bulk_viscosity == BulkViscosity()
    said = ("modes = 4", "modes = 4, yield_stress = 90e6")
    none = ("modulus = 300e6 }", "modulus = 300e6 }, bulk_viscosity = { linear = 0, quadratic = 0 }")
    system = read_case(bar(said, none)).system
    assert system.placed("rest").body.yield_stress == 90e6
    assert not system.placed("nose").body.bulk_viscosity.acts


def test_the_table_of_a_run_has_the_forces_of_its_contacts(bar):
    case = read_case(bar())
    names = [each.name for each in recorded_quantities(case, case.system)]
    assert names == ["contact of nose.TIP", "position nose.JOINT", "energy"]
    moving = ("normal = [-1.0, 0.0, 0.0]", "normal = [-1.0, 0.0, 0.0], mass = 2.0")
    case = read_case(bar(moving))
    obstacle = recorded_quantities(case, case.system)[1]
    assert obstacle.name == "obstacle of nose.TIP"
    series = {OBSTACLES: np.array([[0, 0, 0, -1.0, 0, 0], [-0.5, 0, 0, 3.0, 0, 0]])}
    run = Solution(np.arange(2.0), {}, {}, Statistics(), series=series)
    (reading,) = read_sensors([obstacle], case.system, run)
    assert [channel.name for channel in reading.channels] == ["x", "y", "z", "vx", "vy", "vz"]
    assert reading.values[1, 3] == 3.0


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("density = 2700.0", "density = 2.7e-9", "'nose': the density is 2.7e-09 kg/m3; steel has 7850"),
        ("yield_stress = 100e6", "yield_stress = 100e9", "'nose': the yield stress is 1e.11 Pa, and Young's"),
    ],
)
def test_implausible_numbers_of_explicit_elements_are_warned_of(bar, old, new, message):
    """A stress in another unit than the modulus makes a plastic part elastic, or the reverse."""
    with pytest.warns(UnitsWarning) as heard:
        warn_of_units(read_case(bar((old, new))))
    assert [each for each in heard if re.search(message, str(each.message))]


def test_two_modal_parts_are_tied_as_the_file_says(bar):
    explicit = 'explicit = { law = { kind = "j2", yield_stress = 100e6, modulus = 300e6 } }'
    modal = (
        explicit,
        'modal = { modes = 3 }\ninterface = [{ name = "JOINT", kind = "averaging", nodes = "JOINT" }]',
    )
    assert read_case(bar(modal)).system.ties[0].continuity == MeanMotion()
    every = ('on = "rest"', 'on = "rest"\ncontinuity = { kind = "every-node", tolerance = 1e-3 }')
    system = read_case(bar(modal, every)).system
    assert system.ties[0].continuity == EveryNode(1e-3)
    mortar = ('on = "rest"', 'on = "rest"\ntransfer = { kind = "mortar" }')
    assert read_case(bar(mortar)).system.ties[0].transfer == Mortar()
    nodal = (
        'modal = { modes = 4 }\ninterface = [{ name = "JOINT", kind = "averaging", nodes = "JOINT" }]',
        "explicit = {}",
    )
    with pytest.raises(CaseError, match="a mortar is for ties to modal parts"):
        read_case(bar(mortar, nodal))


def test_a_node_set_that_no_mesh_has_is_named(bar):
    with pytest.raises(CaseError, match="did you mean 'TIP'"):
        _ = read_case(bar(('nodes = "nose.TIP"', 'nodes = "nose.TIPS"'))).system


def test_a_file_of_parts_is_told_how_to_say_it_now(bar):
    path = bar(("[[body]]", "[[part]]"))
    alone = r"one mistake:\n  line .*, part: \[\[part\]\] is now \[\[body\]\]: rename these tables; modal = "
    with pytest.raises(CaseError, match=alone):
        read_case(path)


def test_every_command_reads_such_a_case(bar):
    path = bar()
    shown = CliRunner().invoke(app, ["info", str(path)]).output
    assert "solid, modal in 4 modes" in shown
    assert "solid, explicit elements" in shown
    checked = CliRunner().invoke(app, ["check", str(path)])
    assert checked.exit_code == 0, checked.output
    assert "Check of body 'rest'" in checked.output
    for command in ("static", "modes"):
        said = CliRunner().invoke(app, [command, str(path), "-o", str(path.parent / command)]).output
        assert "has explicit finite elements, which" in " ".join(said.split())


PLATE = """
title = "a plate"
[[body]]
name = "plate"
mesh = "plate.inp"
shell = { youngs_modulus = 70e9, poissons_ratio = 0.3, density = 2700.0, thickness = 0.002 }
explicit = { law = { kind = "j2", yield_stress = 100e6 }, layers = 7, deletion = 0.2 }

[simulation]
duration = 1e-4
output_step = 1e-5
"""


def test_a_shell_yields_by_its_law_and_has_no_key_without_effect(bar, tmp_path):
    nodes = ["1, 0, 0, 0", "2, 1, 0, 0", "3, 0, 1, 0"]
    (tmp_path / "plate.inp").write_text(
        "\n".join(["*NODE", *nodes, "*ELEMENT, TYPE=S3, ELSET=ALL", "1, 1, 2, 3", ""])
    )
    path = tmp_path / "plate.toml"
    path.write_text(PLATE)
    plate = read_case(path).system.placed("plate").body
    assert (plate.law.hardening.initial, plate.layers, plate.deletion) == (100e6, 7, 0.2)
    for old, new, told in (
        ('law = { kind = "j2", yield_stress = 100e6 }, ', "", "an elastic shell has no deletion"),
        ('kind = "j2", yield_stress = 100e6', 'kind = "neo-hookean"', 'a shell takes a law of kind "j2"'),
        ("layers = 7", "hourglass = 0.1", "only hexahedra have hourglass modes"),
        ("layers = 7", "bulk_viscosity = {}", "bulk viscosity is for solids"),
    ):
        path.write_text(PLATE.replace(old, new))
        with pytest.raises(CaseError, match=told):
            read_case(path)
    with pytest.raises(CaseError, match="layers are for shells"):
        read_case(bar(("modulus = 300e6 }", "modulus = 300e6 }, layers = 3")))
    elastic = ('law = { kind = "j2", yield_stress = 100e6, modulus = 300e6 }', "deletion = 0.2")
    with pytest.raises(CaseError, match="an elastic part has no deletion"):
        read_case(bar(elastic))
