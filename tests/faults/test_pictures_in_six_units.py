"""One machine in six systems of units: the same words on the terminal and the same pictures, up to the unit.

Pictures are compared before they are pixels: curves, limits, marks of the axes, labels, bars, and the images
of surfaces. A mark must state the number at which it stands.
"""

from __future__ import annotations

import re

import numpy as np
import pytest
from fixtures.arm_on_a_hub import write_machine
from fixtures.systems_of_units import POWERS, SYSTEMS
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Text
from typer.testing import CliRunner

from supple.cli.main import app
from supple.units import UnitSystem

REFERENCE = "m-kg-s"
NUMBER = r"[-−+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?"
QUANTITIES = {
    "time": "time",
    "force": "force",
    "moment": "moment",
    "deflection": "length",
    "displacement": "length",
    "x, global": "length",
    "y, global": "length",
    "z, global": "length",
}
PREFIXES = {"": 1.0, "m": 1e-3, "µ": 1e-6, "k": 1e3, "M": 1e6, "G": 1e9}


class Drawn:
    """What stands in the pictures of a run, and in what unit.

    axes : dict     of curves and surfaces, by picture and number
    """

    def __init__(self, units):
        self.units = units
        self.words = ""
        self.axes = {}
        self.legends = {}

    def hear(self, figure, target):
        figure.canvas.draw()
        picture = target.name.removeprefix(".").partition(".png")[0]
        self.legends[picture] = [text.get_text() for each in figure.legends for text in each.get_texts()]
        for number, axes in enumerate(figure.axes):
            self.axes[picture, number] = axes

    def factor(self, label):
        """Of what a label speaks of, into SI."""
        plain = label.partition(" (")[0]
        if plain == "von Mises stress":
            return 6894.757293168361 if self.units.stress_shown.unit == "psi" else 1e6
        quantity = next(
            (
                known
                for word, known in QUANTITIES.items()
                if re.fullmatch(rf"{word}(,? (joint )?[xyz])?", plain)
            ),
            None,
        )
        return 1.0 if quantity is None else self.units.in_si(**POWERS[quantity])

    def unit(self, label):
        plain = label.partition(" (")[0]
        if plain == "von Mises stress":
            return self.units.stress_shown.unit
        quantity = next(known for word, known in QUANTITIES.items() if plain.startswith(word))
        return getattr(self.units, quantity)


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    """Words and pictures of `supple run` in every system."""
    found = {}
    with pytest.MonkeyPatch.context() as patched:
        for name, said in SYSTEMS.items():
            one = found[name] = Drawn(UnitSystem.stated(said))
            patched.setattr(
                FigureCanvasAgg, "print_png", lambda self, target, one=one: one.hear(self.figure, target)
            )
            path = write_machine(tmp_path_factory.mktemp("units") / "case", said, steps=4, pictures=True)
            done = CliRunner().invoke(app, ["run", str(path), "-o", str(path.parent / "out")])
            assert done.exit_code == 0, done.output
            one.words = done.output.replace(str(path.parent), "FOLDER")
    return found


def near(found, expected, what, tolerance=1e-6):
    size = np.abs(expected).max(initial=0.0)
    np.testing.assert_allclose(found, expected, rtol=0, atol=tolerance * size + 1e-15, err_msg=what)


def label_without_unit(label):
    return re.sub(r" \([^)]*\)$", "", label)


@pytest.mark.slow
def test_the_words_are_the_same_up_to_numbers_and_units(drawn):
    """Every line of the terminal: the same words in the same order, and units of the case only."""

    def shape(one):
        names = {getattr(one.units, what) for what in (*POWERS, "stress", "velocity")} - {""}
        units = "|".join(re.escape(name) for name in sorted(names, key=len, reverse=True))
        text = re.sub(r"[━┃┏┓┡┩┳╇│└┘┴─]+", " ", one.words)
        text = re.sub(rf"{NUMBER} s of", "seconds of", text)  # by the clock
        text = re.sub(rf"(?<=, )({units})(?= |$)", "UNIT", text, flags=re.MULTILINE)
        text = re.sub(rf"({NUMBER}) ({units})(?=\W|$)", r"\1 UNIT", text)
        return " ".join(re.sub(NUMBER, "N", re.sub(r"\d+:\d\d:\d\d", "", text)).split())

    expected = shape(drawn[REFERENCE])
    assert expected.count("UNIT") > 10
    for name, one in drawn.items():
        assert shape(one) == expected, name


@pytest.mark.slow
def test_curves_are_the_same_once_they_are_converted(drawn):
    reference = drawn[REFERENCE]
    n_curves = 0
    for name, one in drawn.items():
        assert one.axes.keys() == reference.axes.keys()
        assert one.legends == reference.legends
        for place in [place for place in one.axes if place[0] in ("tracked-motion", "joint-forces")]:
            here, there = one.axes[place], reference.axes[place]
            label, expected = here.get_ylabel(), there.get_ylabel()
            assert label_without_unit(label) == label_without_unit(expected)
            assert label == f"{label_without_unit(label)} ({one.unit(label)})"
            if here.get_xlabel():
                assert here.get_xlabel() == f"time ({one.units.time})"
            times, values = one.units.in_si(time=1), one.factor(label)
            size = max(np.abs(line.get_ydata()).max() for line in there.lines) * reference.factor(expected)
            for line, known in zip(here.lines, there.lines, strict=True):
                n_curves += 1
                what = f"{name}, {place}, {known.get_label()}"
                assert line.get_label() == known.get_label()
                near(line.get_xdata() * times, known.get_xdata(), what)
                difference = line.get_ydata() * values - known.get_ydata() * reference.factor(expected)
                assert np.abs(difference).max() <= 1e-6 * size, what
            near(np.array(here.get_xlim()) * times, there.get_xlim(), f"{name}, {place}: limits")
            if size > 0:
                limits = np.array(there.get_ylim()) * reference.factor(expected)
                near(np.array(here.get_ylim()) * values, limits, f"{name}, {place}: limits", 1e-5)
    assert n_curves == 6 * (4 * 3 + 2 * 3 * 3 - 3)


@pytest.mark.slow
def test_marks_state_the_numbers_at_which_they_stand(drawn):
    n_marks = 0
    for name, one in drawn.items():
        for place, axes in one.axes.items():
            for axis in (axes.xaxis, axes.yaxis):
                power = re.search(r"10\^\{(.*?)\}", axis.get_offset_text().get_text())
                scale = 10.0 ** float(power[1].replace("−", "-")) if power else 1.0
                low, high = sorted(axis.get_view_interval())
                for tick in axis.get_major_ticks():
                    at, text = tick.get_loc(), tick.label1
                    plain = re.sub(r"\$|\\mathdefault{|}", "", text.get_text())
                    if not (plain and text.get_visible() and axes.axison and low <= at <= high):
                        continue
                    number = re.fullmatch(rf"({NUMBER}) ?([mµkMG]?)", plain)
                    assert number, f"{name}, {place}: {text.get_text()!r}"
                    n_marks += 1
                    stated = float(number[1].replace("−", "-")) * scale * PREFIXES[number[2]]
                    assert abs(stated - at) <= 0.005 * (high - low), (
                        f"{name}, {place}: {text.get_text()} at {at}"
                    )
    assert n_marks > 6 * 50


@pytest.mark.slow
def test_surfaces_are_the_same_picture(drawn):
    """Pixel by pixel, but for a few on the rims; stress lies in bands of its own in psi."""
    n_images = 0
    for name, one in drawn.items():
        for place, axes in one.axes.items():
            same_bands = one.units.stress_shown.unit == "MPa"
            known = drawn[REFERENCE if same_bands or place[0] != "arm-stress" else "in-lbf-s"]
            images = [image.get_array() for image in axes.images]
            for found, expected in zip(images, known.axes[place].images, strict=True):
                n_images += 1
                difference = np.abs(found.astype(float) - expected.get_array()).max(axis=2)
                whole = 255.0 if found.dtype == np.uint8 else 1.0
                assert np.mean(difference > 0.01 * whole) < 0.002, f"{name}, {place}"
    assert n_images >= 6 * 5


@pytest.mark.slow
def test_bars_and_remarks_of_surfaces_are_the_same_once_they_are_converted(drawn):
    reference = drawn[REFERENCE]
    for name, one in drawn.items():
        metres = one.units.in_si(length=1)
        for place, axes in one.axes.items():
            there = reference.axes[place]
            # A title of a mode is its frequency, which is in Hz everywhere.
            titles = [each.get_title() for each in (axes, there)]
            if found := re.search(rf"t = ({NUMBER}) (\S+?)(,|$)", titles[0]):
                expected = re.search(rf"t = ({NUMBER}) s", titles[1])
                seconds = float(found[1]) * one.units.in_si(time=1)
                assert seconds == pytest.approx(float(expected[1]), rel=1e-3, abs=1e-12)
                assert found[2] == one.units.time
                titles = [re.sub(r"t = \S+ [^\s,]+", "t", each) for each in titles]
            assert titles[0] == titles[1], name
            # The bar is as long as is written on it, and the page as wide as elsewhere.
            for line in axes.lines if axes.images else ():
                if len(line.get_xdata()) == 2:
                    (said,) = [
                        found
                        for text in axes.texts
                        if (found := re.fullmatch(rf"({NUMBER}) {one.units.length}", text.get_text()))
                    ]
                    assert np.ptp(line.get_xdata()) == pytest.approx(float(said[1]), rel=1e-9)
                    assert 1 / 15 < float(said[1]) / np.ptp(axes.get_xlim()) <= 1 / 6 + 1e-9
                    near(np.array(axes.get_xlim()) * metres, there.get_xlim(), f"{name}, {place}", 1e-5)
            marks = [[each.get_text() for each in own.findobj(Text)] for own in (axes, there)]
            largest = [[each for each in own if each.startswith("largest")] for own in marks]
            for found, expected in zip(*largest, strict=True):
                value, node = re.fullmatch(r"largest (\S+), node (\d+)", found).groups()
                known, same = re.fullmatch(r"largest (\S+), node (\d+)", expected).groups()
                assert node == same
                stress = one.factor("von Mises stress") / 1e6
                assert float(value) * stress == pytest.approx(float(known), rel=1e-3)
        # Bars of colour: their label, and the range of what they show.
        label = one.axes["arm-deformed", 1].get_xlabel()
        assert label == f"displacement ({one.units.length})"
        shown = np.array(one.axes["arm-deformed", 1].get_xlim()) * metres
        near(shown, reference.axes["arm-deformed", 1].get_xlim(), name, 1e-5)
        assert one.axes["arm-stress", 1].get_xlabel() == f"von Mises stress ({one.units.stress_shown.unit})"
