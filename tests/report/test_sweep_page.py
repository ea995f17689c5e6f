"""The page of a sweep: what it holds, and in a browser that it sorts, filters, plots and asks for nothing."""

import json
import re

import numpy as np
import pytest
from fixtures.moving_machines import MESH, two_bodies
from fixtures.report_page import ReadPage
from report.test_browser import BROWSER, DRIVER, Browser

from supple.errors import ModelError
from supple.report import (
    ChannelOfCases,
    RainflowSpectrum,
    SweepPage,
    channels_that_fit,
    write_report,
    write_sweep_page,
)
from supple.report.page import PageSection

N = 120
SPEED = np.repeat([4.0, 8.0, 12.0, 16.0], 30)
LARGEST = SPEED**2 + np.random.default_rng(0).standard_normal(N)
LARGEST[7] = np.nan
INSTANTS = np.linspace(1.0, 99.0, N)


def page(**changes):
    root = ChannelOfCases(
        "root.My",
        "N m",
        {
            "maximum": LARGEST,
            "minimum": -0.5 * LARGEST,
            "time of maximum": INSTANTS,
            "time of minimum": INSTANTS[::-1],
        },
    )
    known = {
        "title": "sweep <of> a blade",
        "parameters": {
            "wind.speed": SPEED,
            "angle": np.arange(N) * 0.1,
            "file": [f"wind-{i % 3}.csv" for i in range(N)],
        },
        "channels": [root],
        "results": {"status": ["failed" if i == 7 else "ran" for i in range(N)]},
        "spectra": [RainflowSpectrum("root.My", "N m", np.array([1.0, 10.0]), np.array([1e4, 3.0]))],
        "exponents": [4.0],
        "sections": [PageSection("Sweep", ["case 7: </script><b>diverged</b>"])],
        "reports": {int(np.nanargmax(LARGEST)): "cases/largest.html"},
        "time": "s",
    }
    return SweepPage(**known | changes)


def test_columns_are_in_the_file_to_the_last_bit(tmp_path):
    read = ReadPage(write_sweep_page(tmp_path / "sweep.html", page()))
    columns = read.cases()
    assert np.array_equal(columns["wind.speed"], SPEED)
    assert np.array_equal(columns["root.My, maximum (N m)"], LARGEST, equal_nan=True)
    assert np.array_equal(columns["root.My, time of maximum (s)"], INSTANTS)
    assert columns["file"] == [f"wind-{i % 3}.csv" for i in range(N)]
    assert "<b>diverged" not in read.text
    assert "http" not in re.search(r"Content-Security-Policy.*?>", read.text).group(0)


def test_a_page_holds_what_a_browser_opens():
    assert channels_that_fit(1880, 5, 8) > 200
    assert 1 <= channels_that_fit(100_000, 5, 8) <= 5
    assert channels_that_fit(10**7, 5, 8) == 1


def test_columns_of_different_lengths_are_refused(tmp_path):
    with pytest.raises(ModelError, match="different lengths"):
        write_sweep_page(tmp_path / "sweep.html", page(parameters={"wind.speed": SPEED[1:]}))


@pytest.fixture(scope="module")
def opened(tmp_path_factory):
    """The page in a headless browser."""
    if not (BROWSER and DRIVER):
        pytest.skip("needs Chromium and its driver")
    folder = tmp_path_factory.mktemp("sweep")
    browser = Browser(folder / "profile")
    browser.clear()
    browser.driver.get(write_sweep_page(folder / "sweep.html", page()).as_uri())
    browser.wait("return Boolean(window.sweep)")
    yield browser
    browser.driver.quit()


@pytest.fixture
def browser(opened):
    """All cases, in the order of their numbers."""
    opened.run("sweep.cases.order = { column: 0, rises: true }; document.getElementById('clear').click()")
    return opened


def choose(browser, name, label):
    browser.run(f"""
        const select = document.querySelector('[data-choice={name}]');
        select.value = [...select.options].find((each) => each.textContent === {json.dumps(label)}).value;
        select.dispatchEvent(new Event('change'))""")


def filtered(browser, label, text):
    """Rows shown with a text in the filter of a column."""
    return browser.run(f"""
        const input = document.querySelector('#cases input[aria-label={json.dumps(f"filter of {label}")}]');
        input.value = {json.dumps(text)}; input.dispatchEvent(new Event('input'));
        return input.checkValidity() ? sweep.cases.rows : null""")


@pytest.mark.slow
def test_it_opens_without_complaint_or_request(browser):
    assert browser.complaints() == []
    assert browser.requests() == []
    assert browser.run("return document.querySelectorAll('#cases tbody tr').length") == 50
    assert browser.run("return document.getElementById('page').textContent") == "page 1 of 3"
    assert browser.run("return document.querySelectorAll('.u-wrap').length") == 3


@pytest.mark.slow
def test_a_click_on_a_head_sorts_with_missing_values_last(browser):
    click = """[...document.querySelectorAll('#cases th button')]
        .find((each) => each.textContent.startsWith('root.My, maximum')).click(); return sweep.cases.rows"""
    rises, falls = browser.run(click), browser.run(click)
    order = np.argsort(np.where(np.isnan(LARGEST), np.inf, LARGEST), kind="stable").tolist()
    assert rises == order
    assert falls == [*order[-2::-1], 7]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("label", "text", "expected"),
    [
        ("wind.speed", "> 8", np.flatnonzero(SPEED > 8)),
        ("wind.speed", ">=8", np.flatnonzero(SPEED >= 8)),
        ("wind.speed", "= 12", np.flatnonzero(SPEED == 12)),
        ("wind.speed", "7.5 .. 1.2e1", np.flatnonzero((SPEED > 7) & (SPEED <= 12))),
        ("root.My, maximum (N m)", "< 20", np.flatnonzero(LARGEST < 20)),
        ("angle", "= 0.3", [3]),
        ("angle", "> 0.3", range(3, N)),  # 0.30000000000000004
        ("case", "17", [17]),
        ("file", "D-1", np.arange(1, N, 3)),
        ("status", "fail", [7]),
        ("wind.speed", "> fast", None),
    ],
)
def test_filters(browser, label, text, expected):
    found = filtered(browser, label, text)
    assert found == (None if expected is None else list(expected))


@pytest.mark.slow
def test_plots_and_extremes_are_of_the_cases_shown(browser):
    choose(browser, "x", "wind.speed")
    choose(browser, "y", "root.My, maximum (N m)")
    filtered(browser, "wind.speed", "< 10")
    shown = np.sort(LARGEST[(SPEED < 10) & ~np.isnan(LARGEST)])
    assert browser.run("return Array.from(sweep.exceedance.values)") == shown.tolist()
    n = len(shown)
    assert browser.run("return sweep.exceedance.shares") == pytest.approx((n - np.arange(n)) / (n + 1))
    assert len(browser.run("return sweep.scatter.rows")) == n
    cells = browser.run(
        "return [...document.querySelectorAll('#extremes tbody td')].map((td) => td.textContent)"
    )
    largest = int(np.nanargmax(np.where(SPEED < 10, LARGEST, np.nan)))
    assert cells[6] == str(largest)
    assert float(cells[5]) == pytest.approx(LARGEST[largest], rel=1e-5)
    assert cells[7] == f"{INSTANTS[largest]:.5g} s"


@pytest.mark.slow
def test_the_extreme_case_leads_to_its_report_at_the_instant(browser):
    largest = int(np.nanargmax(LARGEST))
    addresses = browser.run(
        "return [...document.querySelectorAll('#extremes a')].map((each) => each.getAttribute('href'))"
    )
    # The smallest value is of the same case, at another instant.
    instants = [INSTANTS[::-1][largest], INSTANTS[largest]]
    assert addresses == [f"cases/largest.html#t={float(instant)!r}" for instant in instants]


@pytest.mark.slow
def test_a_report_opens_at_the_instant_of_its_address(opened, tmp_path, clamped_blade):
    path = write_report(tmp_path / "run.html", *two_bodies(clamped_blade), {"blade": MESH})
    opened.clear()
    page = opened.driver.current_url
    opened.driver.get(path.as_uri() + "#t=2.75")
    opened.wait("return Boolean(window.report)")
    assert opened.run("return document.getElementById('now').textContent") == "t = 2.75"
    opened.driver.get(page)
    opened.wait("return Boolean(window.sweep)")


@pytest.mark.slow
def test_a_click_on_a_point_is_on_its_case(browser):
    choose(browser, "x", "wind.speed")
    choose(browser, "colour", "wind.speed")
    picked = browser.run("""
        const { graph, x, y } = sweep.scatter;
        return sweep.scatter.pickAt(graph.valToPos(x.values[95], 'x'), graph.valToPos(y.values[95], 'y'))""")
    assert abs(LARGEST[picked] - LARGEST[95]) < 1  # points of one speed lie close
    assert browser.run("return document.querySelector('#cases tr.picked td').textContent") == str(picked)
    assert "wind.speed 16" in browser.run("return document.getElementById('chosen').textContent")
    assert browser.run("return sweep.scatter.graph.series.length") == 5  # a colour each speed


@pytest.mark.slow
def test_spectra_in_cycles_and_in_shares_of_damage(browser):
    choose(browser, "measure", "cumulated cycles")
    assert browser.run("return sweep.spectrum.values") == [10003, 3]
    choose(browser, "measure", "shares of damage, m = 4")
    assert browser.run("return sweep.spectrum.values") == pytest.approx([0.25, 0.75])


@pytest.mark.slow
def test_light_and_dark(browser):
    theme = "return document.documentElement.dataset.theme"
    before = browser.run(theme)
    browser.run("document.getElementById('theme').click()")
    assert {before, browser.run(theme)} == {"light", "dark"}
    assert browser.complaints() == []
