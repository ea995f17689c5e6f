"""`supple reduce` keeps the bodies of a case, and a case with such a file runs as the case itself."""

from __future__ import annotations

import re
import shutil

import numpy as np
import pytest
from fixtures.strip_case import filled
from typer.testing import CliRunner

from supple.cases import read_case
from supple.cli.main import app
from supple.errors import CaseError
from supple.storage import read_reduced_body, read_solution


def call(*arguments, code=0):
    """Output of a command (errors included), its lines joined so that wrapping does not matter."""
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    assert result.exit_code == code, result.output
    return re.sub(r"\s+", " ", result.output)


@pytest.fixture
def case(case_folder):
    """The clamped strip for a hundredth of a second."""
    path = case_folder / "strip.toml"
    path.write_text(path.read_text().replace("duration = 0.4", "duration = 0.01"))
    return path


@pytest.fixture(scope="module")
def reduced_strip(tmp_path_factory):
    """The file that the command writes of the strip."""
    folder = filled(tmp_path_factory.mktemp("reduced"))
    call("reduce", folder / "strip.toml", "-o", folder)
    return folder / "strip-reduced.h5"


@pytest.fixture
def reduced_case(case):
    """The same with the reduced body in place of its mesh; call it once the body is written."""

    def write(old="", new=""):
        text = case.read_text()
        start, end = text.index("mesh ="), text.index("[[joint]]")
        text = text[:start] + 'reduced = "strip-reduced.h5"\n\n' + text[end:]
        path = case.with_name("small.toml")
        path.write_text(
            text.replace('"strip.TIP", ', "").replace(old, new) if old else text.replace('"strip.TIP", ', "")
        )
        return path

    return write


def test_reduce_writes_each_body_and_says_what_it_is(case):
    output = call("reduce", case, "-o", case.parent)
    for part in ("Bodies", "Reduction of strip", "linear", "derivatives", "dropped", "written to"):
        assert part in output
    body = read_reduced_body(case.parent / "strip-reduced.h5")
    assert [interface.name for interface in body.interfaces] == ["root"]
    assert body.cubic is not None
    output = call("info", case.parent / "strip-reduced.h5")
    for part in (
        "Reduced body",
        f"{body.r} of {len(body.nodal_basis)} freedoms, nonlinear",
        "interface root",
    ):
        assert part in output


@pytest.mark.slow
def test_a_case_with_the_file_runs_as_the_case_itself(reduced_strip, case, reduced_case):
    shutil.copy(reduced_strip, case.parent)
    small = reduced_case()
    assert "body strip reduced; interfaces: root" in call("info", small).replace("│ ", "")
    call("run", case, "-o", case.parent / "out")
    call("run", small, "-o", case.parent / "out")
    one, other = (read_solution(case.parent / "out" / f"{name}.h5") for name in ("strip", "small"))
    np.testing.assert_array_equal(one.bodies["strip"].coordinates, other.bodies["strip"].coordinates)
    np.testing.assert_array_equal(one.joint_forces["clamp"], other.joint_forces["clamp"])


def test_a_case_without_a_body_of_fixed_size_has_nothing_to_reduce(reduced_strip, case, reduced_case):
    shutil.copy(reduced_strip, case.parent)
    output = call("reduce", reduced_case(), "-o", case.parent / "out", code=2)
    assert "has no body to reduce: give an elastic body a reduction of fixed size" in output
    assert not (case.parent / "out").exists()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            'reduced = "strip-reduced.h5"',
            'reduced = "strp-reduced.h5"',
            r"body\[1\]\.reduced: cannot read .*strp-reduced\.h5: no such file",
        ),
        ("strip.root", "strip.rot", "no interface of 'strip' named 'rot', did you mean 'root'"),
        (
            'reduced = "strip-reduced.h5"',
            'reduced = "strip-reduced.h5"\nmesh = "strip.inp"',
            r"body\[1\]\.mesh: a reduced body takes no mesh; remove the key",
        ),
        (
            'reduced = "strip-reduced.h5"',
            'reduced = "strip-reduced.h5"\ndamping = { kind = "modal", ratio = 0.01 }',
            "a reduced body takes no damping; remove the key",
        ),
        (
            'reduced = "strip-reduced.h5"',
            'reduced = "strip-reduced.h5"\ninterface = [{ name = "root", nodes = "ROOT" }]',
            "the file of a reduced body has its interfaces; remove these",
        ),
    ],
)
def test_mistakes_with_reduced_bodies_are_named(reduced_strip, case, reduced_case, old, new, message):
    shutil.copy(reduced_strip, case.parent)
    with pytest.raises(CaseError, match=message):
        read_case(reduced_case(old, new))


def test_a_file_that_is_no_reduced_body_is_a_mistake_with_its_line(case, reduced_case):
    (case.parent / "strip-reduced.h5").write_text("no HDF5")
    with pytest.raises(CaseError, match=r"line 6, body\[1\]\.reduced: cannot read .*not an HDF5 file"):
        read_case(reduced_case())
