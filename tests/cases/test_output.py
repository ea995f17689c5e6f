"""What a case asks of its pictures and its film is what is drawn; mistakes are found before anything runs."""

from __future__ import annotations

import importlib.util

import numpy as np
import pytest

from supple.cases import drawing, read_case
from supple.cases.drawing import check_drawing
from supple.errors import CaseError
from supple.results.film import Film, RotorAngle


@pytest.fixture
def case_with(case_folder):
    """The case of a strip with other lines under [output], and with a revolute joint of the name 'clamp'."""

    def write(lines):
        path = case_folder / "strip.toml"
        text = path.read_text().replace("animation = false", f"animation = true\n{lines}")
        path.write_text(text.replace('kind = "fixed"', 'kind = "revolute"\naxis = [0.0, 1.0, 0.0]'))
        return read_case(path)

    return write


def test_keys_are_the_objects_of_python(case_with):
    output = case_with(
        "film = { frames_per_second = 25, speed = 0.1, start = 0.1, end = 0.3 }\n"
        "camera = { along = [0.0, 2.0, 0.0], up = [0.0, 0.0, 1.0] }\nenlargement = 20.0"
    ).tables.output
    assert output.film.build() == Film(25.0, speed=0.1, start=0.1, end=0.3)
    assert output.film.format == "gif"
    np.testing.assert_allclose(output.view.camera.axes, [[1, 0, 0], [0, 0, 1], [0, -1, 0]], atol=1e-15)
    assert output.view.enlargement == 20.0


def test_what_is_left_out_is_the_default_of_python(case_with):
    output = case_with("").tables.output
    assert output.film.build() == Film()
    assert (output.view.camera, output.view.enlargement) == (None, None)


def test_a_stroboscope_is_a_joint_and_an_angle(case_with):
    output = case_with('film = { joint = "clamp", angle = 0.5 }').tables.output
    assert output.film.build() == Film(at=RotorAngle("clamp", 0.5))


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ('film = { joint = "shaft" }', "there is no joint 'shaft'; there are: clamp"),
        ("film = { angle = 0.5 }", "angle needs a joint"),
        ('film = { joint = "clamp", speed = 0.5 }', "a speed, or one frame per passage"),
        ("film = { frames_per_second = 60 }", "60 frames a second: give at most 50"),
        ("film = { start = 0.3, end = 0.2 }", "from 0.3 to 0.2 is empty"),
        ("film = { speed = 0.0 }", "greater than 0"),
        ('film = { format = "avi" }', "gif"),
        ("camera = { along = [0.0, 0.0, 1.0], up = [0.0, 0.0, 2.0] }", "not parallel"),
        ("camera = { along = [0.0, 0.0, 1.0] }", "up"),
        ("enlargement = 0.0", "greater than 0"),
    ],
)
def test_mistakes_are_found_when_the_case_is_read(case_with, lines, message):
    with pytest.raises(CaseError, match=message):
        case_with(lines)


def test_an_mp4_without_ffmpeg_is_refused_before_the_run(case_with, monkeypatch):
    case = case_with('film = { format = "mp4" }')
    found = importlib.util.find_spec
    monkeypatch.setattr(drawing, "find_spec", lambda name: None if name == "imageio_ffmpeg" else found(name))
    with pytest.raises(CaseError, match=r"pip install 'supple\[film\]', or give format = \"gif\""):
        check_drawing(case)


@pytest.mark.parametrize(
    ("film", "message"),
    [
        ("{ start = 0.5 }", r"from 0\.5 to 0\.4 shows no output time: the run goes from 0 to 0\.4"),
        ("{ speed = 1e-4 }", "an animation of 48001 frames exceeds 2000"),
        ('{ joint = "clamp", end = -1.0 }', "shows no output time"),
    ],
)
def test_a_film_that_shows_nothing_of_the_run_is_refused_before_it(case_with, film, message):
    with pytest.raises(CaseError, match=message):
        check_drawing(case_with(f"film = {film}"))


def test_explicit_elements_are_not_enlarged(case_folder):
    path = case_folder / "strip.toml"
    text = path.read_text().replace("animation = false", "animation = true\nenlargement = 3.0")
    body = text.index("frame = {"), text.index("[[body.interface]]")
    path.write_text(text[: body[0]] + "explicit = {}\n" + text[body[1] :])
    with pytest.raises(
        CaseError, match="explicit elements have no separate rigid motion and deformation; remove the key"
    ):
        read_case(path)
