"""Films show the output times that they are asked for, at the speed that is written in them."""

from __future__ import annotations

import sys
from itertools import pairwise

import numpy as np
import pytest
from PIL import Image

from supple.errors import MissingPackageError, ModelError
from supple.mesh import skin_of, strip
from supple.results.film import MOST_FRAMES, Film, RotorAngle, film_rows, speed_words
from supple.units import SI, UNNAMED, UnitSystem
from supple.viz import animate
from supple.viz.film_file import played_rate

T = np.linspace(0.0, 10.0, 1001)


def rows_of(film, times=T, rate=None, angles=None):
    return film_rows(film, times, rate or film.frames_per_second, angles)


# --- which output times


def test_frames_pass_at_the_speed_asked_for():
    """25 frames a second at a fifth of real time: one every 0.008 s, shown by the nearest output time."""
    rows = rows_of(Film(25.0, speed=0.2))
    wanted = 0.008 * np.arange(1251)
    assert len(rows) == len(wanted)
    assert np.abs(T[rows] - wanted).max() <= 0.005 + 1e-12
    assert speed_words(T[rows], 25.0, SI) == "0.2 × real time"


def test_output_times_are_shown_again_where_the_film_is_slower_than_they_are():
    rows = rows_of(Film(10.0, speed=0.04, end=0.02))
    assert rows.tolist() == [0, 0, 1, 1, 2, 2]


def test_the_window_holds_the_times_between_its_ends_and_both_of_them():
    rows = rows_of(Film(10.0, speed=1.0, start=2.0, end=3.0))
    assert T[rows] == pytest.approx(np.arange(2.0, 3.05, 0.1))
    rows = rows_of(Film(start=0.3, end=0.6))
    assert rows.tolist() == list(range(30, 61))


def test_a_film_without_a_speed_has_sixty_frames_from_end_to_end():
    rows = rows_of(Film())
    assert (len(rows), rows[0], rows[-1]) == (60, 0, 1000)
    assert rows_of(Film(), T[:1]).tolist() == [0]
    assert rows_of(Film(speed=1.0), T[:1]).tolist() == [0]


def test_impossible_films_are_refused():
    with pytest.raises(ModelError, match="60 frames a second: give at most 50"):
        Film(60.0)
    with pytest.raises(ModelError, match="from 3 to 2 is empty"):
        Film(start=3.0, end=2.0)
    with pytest.raises(ModelError, match="a speed, or one frame per passage"):
        Film(speed=1.0, at=RotorAngle("shaft"))
    with pytest.raises(ModelError, match="from 11 to 10 shows no output time: the run goes from 0 to 10"):
        rows_of(Film(start=11.0))
    with pytest.raises(ModelError, match=rf"120001 frames exceeds {MOST_FRAMES}: give a higher speed"):
        rows_of(Film(12.0, speed=1e-3))


# --- a rotor that seems to stand


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_rotor_stands_at_its_angle_in_every_frame(sense):
    """It turns once in 0.73 s, which is no number of output steps."""
    angles = sense * 2 * np.pi * T / 0.73
    film = Film(at=RotorAngle("shaft", 1.0))
    rows = rows_of(film, angles=angles)
    first = 0.73 * ((1.0 * sense / (2 * np.pi)) % 1.0)
    passed = np.arange(first, 10.0, 0.73)
    assert np.abs(T[rows] - passed).max() <= 0.005 + 1e-12
    assert len(rows) == len(passed)


def test_a_rotor_that_begins_at_its_angle_is_shown_there():
    angles = 2 * np.pi * T
    assert T[rows_of(Film(at=RotorAngle("shaft")), angles=angles)] == pytest.approx(np.arange(11.0))
    window = Film(start=2.5, end=5.0, at=RotorAngle("shaft"))
    assert T[rows_of(window, angles=angles)] == pytest.approx([3.0, 4.0, 5.0])


def test_a_rotor_that_comes_back_is_shown_on_both_ways():
    angles = np.sin(2 * np.pi * T / 10.0)
    rows = rows_of(Film(at=RotorAngle("shaft", 0.5)), angles=angles)
    assert T[rows] == pytest.approx([10 / 12, 50 / 12], abs=0.006)


def test_a_rotor_between_whose_output_times_too_much_happens_is_refused():
    with pytest.raises(ModelError, match=r"is 15 deg from 0\.261799 rad at the nearest output time"):
        rows_of(Film(at=RotorAngle("shaft", np.pi / 12)), T[:13], angles=np.pi / 6 * np.arange(13))
    with pytest.raises(ModelError, match="does not pass 2 rad in the animation: it rotates from 0 to 1 rad"):
        rows_of(Film(at=RotorAngle("shaft", 2.0)), angles=0.1 * T)


# --- the speed in words


@pytest.mark.parametrize(
    ("units", "words"),
    [
        (SI, "real time"),
        (UnitSystem("mm", "t", "ms"), "0.001 × real time"),
        (UnitSystem("m", "kg", "min"), "60 × real time"),
        (UNNAMED, "1 a second"),
    ],
)
def test_speed_is_a_share_of_real_time_whatever_the_unit_of_time(units, words):
    assert speed_words(T[::10], 10.0, units) == words


def test_large_speeds_are_no_powers_of_ten():
    assert speed_words(250.0 * T[::10], 10.0, SI) == "250 × real time"
    assert speed_words(T[:1], 10.0, SI) == ""


# --- files


@pytest.fixture
def beam():
    return strip(10.0, 0.5, 8, 2)


def rising(mesh, number):
    return mesh.nodes + np.linspace(0.0, 1.0, number)[:, None, None] * np.array([0.0, 0.0, 1.0])


@pytest.mark.parametrize(("asked", "played"), [(12.0, 12.5), (25.0, 25.0), (30.0, 100 / 3), (50.0, 50.0)])
def test_a_gif_plays_at_the_rate_that_its_speed_is_found_with(tmp_path, beam, asked, played):
    path = animate(
        tmp_path / "film.gif", T[:3], rising(beam, 3), skin_of(beam), frames_per_second=asked, n_columns=120
    )
    assert played_rate(path, asked) == pytest.approx(played)
    with Image.open(path) as film:
        assert film.info["duration"] == round(1000 / played, -1)


def test_frames_shown_again_take_their_time(tmp_path, beam):
    """Equal frames of a GIF are one that stands longer."""
    path = animate(
        tmp_path / "film.gif",
        T[:3],
        rising(beam, 3),
        skin_of(beam),
        shown=np.array([0, 0, 1, 1, 1, 2]),
        frames_per_second=10.0,
        n_columns=120,
    )
    with Image.open(path) as film:
        lasting = []
        for i in range(film.n_frames):
            film.seek(i)
            lasting.append(film.info["duration"])
    assert lasting == [200, 300, 100]


def test_an_mp4_has_the_frames_of_the_gif(tmp_path, beam):
    ffmpeg = pytest.importorskip("imageio_ffmpeg")
    pictures = {}
    for suffix in ("gif", "mp4"):
        pictures[suffix] = animate(
            tmp_path / f"film.{suffix}",
            T[:4],
            rising(beam, 4),
            skin_of(beam),
            frames_per_second=12.5,
            n_columns=201,
        )
    reader = ffmpeg.read_frames(str(pictures["mp4"]))
    about = next(reader)
    frames = [np.frombuffer(frame, np.uint8).reshape(*about["size"][::-1], 3).astype(int) for frame in reader]
    assert (about["fps"], len(frames), about["codec"]) == (12.5, 4, "h264")
    assert all(side % 2 == 0 for side in about["size"])
    with Image.open(pictures["gif"]) as film:
        for i, frame in enumerate(frames):
            film.seek(i)
            theirs = np.asarray(film.convert("RGB"), dtype=int)
            assert np.abs(frame[: theirs.shape[0], : theirs.shape[1]] - theirs).mean() < 4.0
    assert all(np.abs(later - earlier).max() > 50 for earlier, later in pairwise(frames))


def test_an_mp4_without_ffmpeg_names_what_to_install(tmp_path, beam, monkeypatch):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(MissingPackageError, match=r"pip install 'supple\[film\]'"):
        animate(tmp_path / "film.mp4", T[:3], rising(beam, 3), skin_of(beam))
    assert not list(tmp_path.iterdir())
