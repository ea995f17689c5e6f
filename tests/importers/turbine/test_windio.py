"""windIO: one blade in both versions of the schema, and the error messages."""

from pathlib import Path

import numpy as np
import pytest

from supple.errors import ImportFormatError, MeshError, SuppleWarning
from supple.importers.turbine.windio import read_windio_blade
from supple.mesh import BladeGrid, ShearWebs, loft_blade

FILES = [Path(__file__).parent / "windio_blade" / f"version_{version}.yaml" for version in (1, 2)]
X = np.linspace(0, 1, 21)


@pytest.mark.parametrize("path", FILES)
def test_distributions_and_axis(path):
    blade = read_windio_blade(path)
    np.testing.assert_allclose(blade.span, [0, 7.5, 15, 30])
    np.testing.assert_allclose(np.asarray(blade.chord)[[0, 1, 3]], [3, 3, 1])
    np.testing.assert_allclose(blade.twist, np.radians(18) * (1 - blade.span / 30), atol=1e-15)
    np.testing.assert_allclose(blade.pitch_axis, 0.5)
    np.testing.assert_allclose(blade.prebend, -blade.span / 20)
    np.testing.assert_allclose(blade.sweep, blade.span / 100)


@pytest.mark.parametrize("path", FILES)
def test_airfoils_stand_where_the_file_puts_them(path):
    thickness = [np.ptp(section.heights(X), axis=0).max() for section in read_windio_blade(path).sections]
    np.testing.assert_allclose(thickness, [0.6, 0.6, 0.6, 0.2], rtol=1e-3)


def test_thickness_along_the_span_rules_the_blend(tmp_path):
    """Of [0.6 .. 0.2], a relative thickness of 0.4 is met at 0.4, wherever the airfoils stand."""
    text = (
        FILES[1]
        .read_text()
        .replace("grid: [0.0, 0.5, 1.0], values: [0.6, 0.6", "grid: [0.0, 0.5, 1.0], values: [0.6, 0.4")
    )
    section = read_windio_blade(_written(tmp_path, text)).sections[2]
    np.testing.assert_allclose(np.ptp(section.heights(X), axis=0).max(), 0.4, rtol=1e-3)


def test_different_airfoils_of_one_thickness_are_doubtful(tmp_path):
    """The blend over the thickness has room for the first only; the same shape again is no matter."""
    text = (
        FILES[1]
        .read_text()
        .replace("name: thick, spanwise_position: 0.5", "name: other, spanwise_position: 0.5")
    )
    other = "  - name: other\n    rthick: 0.6\n"
    other += "    coordinates: {x: [1.0, 0.5, 0.0, 0.5, 1.0], y: [0.0, 0.4, 0.0, "
    with pytest.warns(SuppleWarning, match="'thick' and 'other' have the same .* 0.6: only 'thick' is used"):
        changed = read_windio_blade(_written(tmp_path, text + other + "-0.2, 0.0]}\n"))
    same = read_windio_blade(_written(tmp_path, text + other.replace("0.4", "0.3") + "-0.3, 0.0]}\n"))
    for a, b in zip(changed.sections, same.sections, strict=True):
        np.testing.assert_array_equal(a.heights(X), b.heights(X))


def test_normal_offset_moves_the_axis(tmp_path):
    text = (
        FILES[1]
        .read_text()
        .replace(
            "      rthick", "      section_offset_x: {grid: [0.0, 1.0], values: [0.2, 0.2]}\n      rthick"
        )
    )
    plain, moved = read_windio_blade(FILES[1]), read_windio_blade(_written(tmp_path, text))
    np.testing.assert_allclose(moved.prebend, plain.prebend + 0.2 * np.cos(plain.twist))
    np.testing.assert_allclose(moved.sweep, plain.sweep - 0.2 * np.sin(plain.twist))


def test_an_imported_blade_can_be_meshed():
    webs = ShearWebs(start=3.0, end=27.0, fore=-0.3, aft=0.3)
    mesh = loft_blade(read_windio_blade(FILES[1]), webs, BladeGrid(web_segments=12))
    np.testing.assert_allclose(np.ptp(mesh.nodes[:, 2]), 30)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("  blade:", "  wing:", r"no entry components\.blade; there are wing"),
        ("outer_shape:", "outer_form:", r"no entry components\.blade\.outer_shape_bem"),
        (
            "name: thick, spanwise_position: 0.5",
            "name: round, spanwise_position: 0.5",
            "unknown airfoil 'round'; it has thin, thick",
        ),
        (
            "values: [3.0, 3.0, 1.0]",
            "values: [3.0, 1.0]",
            r"outer_shape\.chord has 3 grid points and 2 values",
        ),
        (
            "grid: [0.0, 0.25, 1.0], values: [3.0",
            "grid: [0.0, 1.25, 1.0], values: [3.0",
            "the grid ascending",
        ),
        (
            "twist: {grid: [0.0, 1.0]",
            "twist: {grid: [0.1, 1.0]",
            r"outer_shape\.twist is given from 0\.1 to 1, the sections from 0 to 1; extend its grid",
        ),
        (
            "rthick: {grid: [0.0, 0.5",
            "rthick: {grid: [0.1, 0.5",
            r"outer_shape\.rthick is given from 0\.1 to 1, the sections from 0 to 1; extend its grid",
        ),
        (
            "values: [18.0, 0.0]",
            "values: [18.0, flat]",
            r"outer_shape\.twist\.values holds entries that are not numbers",
        ),
        ("y: [0.0, 0.3, 0.0, -0.3, 0.0]", "y: [0.0, 0.3]", "airfoil 'thick' has 5 x and 2 y"),
        ("name: thick, spanwise_position: 0.5", "name: thick, spanwise_position: [", "not readable as YAML"),
        (
            "{name: thin, spanwise_position: 1.0}",
            "{name: thick, spanwise_position: 1.0}",
            "two or more relative thicknesses",
        ),
    ],
)
def test_file_errors(tmp_path, old, new, message):
    assert old in FILES[1].read_text()
    with pytest.raises(ImportFormatError, match=message):
        read_windio_blade(_written(tmp_path, FILES[1].read_text().replace(old, new)))


def test_a_blade_that_cannot_be(tmp_path):
    text = FILES[1].read_text().replace("values: [0.0, 30.0]", "values: [0.0, -30.0]")
    with pytest.raises(MeshError, match=r"blade\.yaml: stations out of order"):
        read_windio_blade(_written(tmp_path, text))


def test_missing_file(tmp_path):
    with pytest.raises(ImportFormatError, match="no such file"):
        read_windio_blade(tmp_path / "none.yaml")


def _written(folder, text):
    path = folder / "blade.yaml"
    path.write_text(text)
    return path
