"""`[[sensor]]`: what it reads is what Python reads, in files, table and report."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest
from typer.testing import CliRunner

from supple.cases import read_case
from supple.cli.main import app
from supple.errors import CaseError
from supple.quantities import Maximum, Mean, Nearest

SENSORS = """
[[sensor]]
name = "tip"
kind = "deflection"
at = "strip.TIP"

[[sensor]]
name = "clamp load"
kind = "joint-force"
joint = "clamp"

[[sensor]]
name = "fibre"
kind = "stress"
at = "strip.ROOT"
measure = "xx"

[[sensor]]
name = "energy"
kind = "energy"

[[sensor]]
name = "cut"
kind = "section-force"
at = "strip.AXIS"
normal = [1, 0, 0]
"""


@pytest.fixture
def case(case_folder):
    path = case_folder / "strip.toml"
    text = path.read_text().replace("duration = 0.4", "duration = 0.04").replace("pictures = false", "")
    path.write_text('units = { length = "m", mass = "kg", time = "s" }\n' + text + SENSORS)
    return path


@pytest.mark.slow
def test_a_run_writes_what_its_sensors_read(case, tmp_path):
    out = tmp_path / "out"
    result = CliRunner().invoke(app, ["run", str(case), "-o", str(out), "--no-errors"])
    assert result.exit_code == 0, result.output
    assert "Sensors" in result.output
    with (out / "sensors.csv").open(newline="") as file:
        heads, *rows = csv.reader(file)
    assert heads[:5] == ["Time_[s]", "tip.x_[m]", "tip.y_[m]", "tip.z_[m]", "clamp load.Fx_[N]"]
    assert "fibre.top xx_[Pa]" in heads
    table = dict(zip(heads, np.array(rows, dtype=float).T, strict=True))
    report = json.loads((out / "strip.json").read_text())
    told = report["sensors"]["tip"]["z"]
    told_fibre = report["sensors"]["fibre"]["top xx"]
    assert told["smallest"] == table["tip.z_[m]"].min() < 0
    assert report["tracked"]["strip.TIP"]["last deflection"][2] == pytest.approx(told["last"])
    assert table["fibre.top xx_[Pa]"][-1] > 0 > table["fibre.bottom xx_[Pa]"][-1]
    assert heads[-6:] == [*(f"cut.F{axis}_[N]" for axis in "xyz"), *(f"cut.M{axis}_[N m]" for axis in "xyz")]
    assert table["cut.Fz_[N]"][-1] < 0 < table["cut.My_[N m]"][-1], "what hangs on it pulls down"
    stress = report["stress"]["strip"]
    assert stress["largest von Mises stress"] >= 0.99 * abs(table["fibre.top xx_[Pa]"]).max()
    assert stress["point"][0] < 0.2
    assert 0 < stress["time"] <= 0.04
    assert str(stress["node"]) in result.output
    assert told_fibre["place"] == "largest of 3 nodes"
    assert told_fibre["point of largest"][0] == 0.0
    assert (out / "sensors.h5").exists()
    assert (out / "sensors.png").stat().st_size > 5_000


def line_of(path, text):
    return 1 + path.read_text()[: path.read_text().index(text)].count("\n")


def test_a_stress_that_is_none_is_found_while_reading(case):
    """An interface is no node set, and a rigid body has no elements: with the line of the key."""
    case.write_text(case.read_text().replace('at = "strip.ROOT"', 'at = "strip.root"'))
    line = line_of(case, 'at = "strip.root"')
    with pytest.raises(CaseError, match=rf"line {line}, sensor\[3\].at: 'root' is an interface"):
        read_case(case)
    text = case.read_text()
    case.write_text(text + '[error]\nof = [{ kind = "stress", at = "strip.root" }]\n')
    with pytest.raises(
        CaseError, match=r"error.of\[1\].at: 'root' is an interface, but stress is computed in elements"
    ):
        read_case(case)
    case.write_text(text)
    inertia = "[[1,0,0],[0,1,0],[0,0,1]]"
    rigid = f'[[body]]\nname = "hub"\nrigid = {{ mass = 1.0, centre = [0,0,0], inertia = {inertia} }}\n'
    text = case.read_text().replace('at = "strip.root"', 'at = "hub.eye"')
    case.write_text(text.replace("[[joint]]", rigid + "[[joint]]"))
    with pytest.raises(CaseError, match=r"sensor\[3\].at: body 'hub' has no elements whose stress"):
        read_case(case)


def test_a_sensor_that_its_body_cannot_serve_is_found_before_the_run(case):
    """A section of a rigid body: refused with its line, not when the run is over."""
    inertia = "[[1,0,0],[0,1,0],[0,0,1]]"
    rigid = f'[[body]]\nname = "hub"\nrigid = {{ mass = 1.0, inertia = {inertia} }}\n'
    eye = '[[body.interface]]\nname = "eye"\nposition = [0, 0, 0]\n'
    sensor = '\n[[sensor]]\nname = "v"\nkind = "section-force"\nat = "hub.eye"\nnormal = [1, 0, 0]\n'
    text = case.read_text()
    case.write_text(text[: text.index("[[sensor]]")].replace("[[joint]]", rigid + eye + "[[joint]]") + sensor)
    line = line_of(case, "[[sensor]]")
    with pytest.raises(CaseError, match=rf"line {line}, sensor\[1\]: sensor 'v': body 'hub' is rigid"):
        _ = read_case(case).sensors


@pytest.mark.parametrize(
    ("element", "cause"),
    [
        ('kind = "angle-stop"\naxis = [0, 1, 0]\nlower = 1.0\nupper = 0.0\nstiffness = 1.0', "lower"),
        ('kind = "gear"\naxis = [0, 1, 0]\nteeth = [20, 40]\nstiffness = 1.0', "needs an anchor"),
        ('kind = "bushing"\nstiffness = [1, 1, -1, 1, 1, 1]', "must not be negative"),
    ],
)
def test_a_mistake_of_an_element_is_found_while_reading_with_its_line(case, element, cause):
    given = f'\n[[element]]\nfirst = "ground"\nsecond = "strip.root"\n{element}\n'
    case.write_text(case.read_text() + given)
    line = line_of(case, "[[element]]")
    with pytest.raises(CaseError, match=rf"line {line}, element\[1\]: .*{cause}"):
        read_case(case)


@pytest.mark.parametrize(
    ("given", "component", "over"),
    [
        ("", "von Mises", Maximum()),
        ('measure = "max"', "von Mises", Maximum()),
        ('measure = "mean"\ncomponent = "yy"', "yy", Mean()),
        ('measure = "nearest"', "von Mises", Nearest()),
        ('measure = "xx"', "xx", Maximum()),
    ],
)
def test_what_is_read_of_a_set(case, given, component, over):
    case.write_text(case.read_text().replace('measure = "xx"', given))
    (sensor,) = [each for each in read_case(case).sensors if each.name == "fibre"]
    assert sensor.measure.names == (component,)
    assert sensor.over == over
    assert len(sensor.nodes) == 3


@pytest.mark.parametrize(
    ("before", "after", "cause"),
    [
        ('joint = "clamp"', 'joint = "clam"', "did you mean 'clamp'"),
        ('at = "strip.TIP"', 'at = "strip.TOP"', "there is no node set named 'TOP'"),
        ('at = "strip.TIP"', 'at = "stripe.TIP"', "did you mean 'strip'"),
        ('name = "energy"', 'name = "tip"', "names must differ"),
        ('name = "energy"', 'name = " "', "is empty"),
        ('name = "energy"', 'name = "time"', "has the output times under the name time"),
        ('name = "energy"', 'name = "tip/side"', "its name lies below that of sensor 'tip'"),
        ('kind = "joint-force"', 'kind = "joint-force"\nseen_from = "strip.root"', "seen_from"),
        ('at = "strip.ROOT"', 'at = "strip.root"', "give a node set of a body with elements"),
        ('measure = "xx"', 'measure = "xxx"', "measure"),
        ('measure = "xx"', 'component = "xx"\nmeasure = "yy"', "with component, measure is one of max"),
        ('measure = "xx"', 'cells = "SKIN"', "no cell set 'SKIN' in this mesh"),
        ("normal = [1, 0, 0]", "", "normal"),
        ('at = "strip.AXIS"', 'at = "strip.TIP"', "sensor 'cut': .* has no elements that share nodes"),
        ("normal = [1, 0, 0]", "normal = [0, 1, 0]", "sensor 'cut': .* at interface 'root'"),
        (
            'kind = "energy"',
            'kind = "angular-velocity"\nat = "strip.TIP"',
            "no interface of 'strip' named 'TIP'",
        ),
    ],
)
def test_a_mistake_is_named(case, before, after, cause):
    case.write_text(case.read_text().replace(before, after))
    with pytest.raises(Exception, match=cause) as seen:
        _ = read_case(case).sensors
    assert isinstance(seen.value, CaseError) or "sensor 'fibre'" in str(seen.value)


def test_sensors_are_read_in_the_equilibrium(case, tmp_path):
    """A uniform cantilever under its weight: W and W L / 2 at the clamp, W / 2 and W L / 8 in the middle."""
    result = CliRunner().invoke(app, ["static", str(case), "-o", str(tmp_path), "--no-errors"])
    assert result.exit_code == 0, result.output
    assert "Sensors" in result.output
    assert "clamp load" in result.output
    numbers = json.loads((tmp_path / "strip-static.json").read_text())
    read = {
        name: {key: own["last"] for key, own in each.items()} for name, each in numbers["sensors"].items()
    }
    assert list(read) == ["tip", "clamp load", "fibre", "energy", "cut"]
    tip = [read["tip"][axis] for axis in "xyz"]
    assert tip == pytest.approx(numbers["tracked"]["strip.TIP"]["last deflection"], rel=1e-9, abs=1e-12)
    weight = 7850.0 * 0.1 * 0.01 * 9.81
    for name, channel, value in (
        ("clamp load", "Fz", weight),
        ("clamp load", "My", -weight / 2),
        ("cut", "Fz", -weight / 2),
        ("cut", "My", weight / 8),
    ):
        assert read[name][channel] == pytest.approx(value, rel=1e-4)
