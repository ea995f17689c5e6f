"""The page in a browser: it plays, is picked and scrubbed, shows what the run has, and asks for nothing."""

import base64
import io
import json
import shutil
import time

import numpy as np
import pytest
from fixtures.moving_machines import MESH, N_TIMES, beam_frame, eroding, two_bodies
from PIL import Image

import supple as sp
from supple.linearization import CampbellDiagram
from supple.quantities import deflections, observer_of
from supple.report import write_campbell_report, write_report
from supple.report.moving_machine import moving_machine
from supple.report.page import Clip, Page, write_page
from supple.results import body_surface
from supple.units import SI

webdriver = pytest.importorskip("selenium.webdriver")
BROWSER = shutil.which("chromium") or shutil.which("google-chrome") or shutil.which("chrome")
DRIVER = shutil.which("chromedriver")
ARGUMENTS = (
    "--headless --no-sandbox --disable-gpu --use-angle=swiftshader --enable-unsafe-swiftshader "
    "--disable-quic --no-first-run --disable-background-networking --disable-component-update --disable-sync "
    "--window-size=1200,900"
)
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not (BROWSER and DRIVER), reason="needs Chromium and its driver"),
]


class Browser:
    """A page in a headless browser."""

    def __init__(self, folder, *arguments):
        options = webdriver.ChromeOptions()
        options.binary_location = BROWSER
        for argument in (*ARGUMENTS.split(), f"--user-data-dir={folder}", *arguments):
            options.add_argument(argument)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
        self.driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(DRIVER))

    def open(self, path):
        self.clear()
        self.driver.get(path.as_uri())
        self.wait("return Boolean(window.report)")
        return self

    def clear(self):
        """Forget what the page before asked for."""
        for log in ("performance", "browser"):
            self.driver.get_log(log)

    def run(self, script):
        return self.driver.execute_script(script)

    def wait(self, script, seconds=60.0):
        end = time.monotonic() + seconds
        while not self.run(script):
            assert time.monotonic() < end, script
            time.sleep(0.05)

    def picture(self):
        """(rows, columns, 3) of the stage."""
        png = self.driver.find_element("id", "view").screenshot_as_png
        return np.asarray(Image.open(io.BytesIO(png)).convert("RGB"))

    def requests(self):
        """Addresses that the page asked for, but its own file."""
        events = (json.loads(entry["message"])["message"] for entry in self.driver.get_log("performance"))
        sent = [
            each["params"]["request"]["url"]
            for each in events
            if each["method"] == "Network.requestWillBeSent"
        ]
        return [url for url in sent if not url.startswith(("file:", "data:", "blob:", "chrome:", "about:"))]

    def complaints(self):
        """What the browser complains of; of software rendering it says that it is slow."""
        return [
            e["message"] for e in self.driver.get_log("browser") if "GL Driver Message" not in e["message"]
        ]


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    found = Browser(tmp_path_factory.mktemp("browser"))
    yield found
    found.driver.quit()


@pytest.fixture
def opened(browser, tmp_path, clamped_blade, blade):
    """The page of two bodies, and their machine and run."""
    system, solution = two_bodies(clamped_blade)
    path = write_report(
        tmp_path / "run.html", system, solution, {"blade": MESH}, elements={"blade": blade.model}, units=SI
    )
    return browser.open(path), system, solution


def test_a_page_opens_without_complaint_or_request(opened):
    browser, *_ = opened
    browser.wait("return !report.player.dirty")
    assert browser.complaints() == []
    assert browser.requests() == []
    assert browser.run("return document.getElementById('message').hidden")
    assert len(np.unique(browser.picture().reshape(-1, 3), axis=0)) > 50


def picked_at(browser, row, point):
    """The reading of a click on a point (3,) in space at an instant."""
    return browser.run(f"""
        const player = report.player, {{ camera, canvas, root }} = player.view;
        player.seekRow({row}); player.draw();
        const middle = player.scene.middle, at = player.bodies[0].position.clone();
        at.set(...{json.dumps(point.tolist())}.map((x, i) => x - middle[i]));
        at.applyMatrix4(root.matrix).project(camera);
        return player.pick((at.x + 1) / 2 * canvas.clientWidth, (1 - at.y) / 2 * canvas.clientHeight);""")


def test_displacement_under_the_pointer(opened):
    """At every few instants, and for a point of the screen found from the positions of the run."""
    browser, system, solution = opened
    body, motion = system.placed("blade").body, solution.bodies["blade"]
    exact, places = deflections(body, motion), sp.node_positions(body, motion)
    largest = np.linalg.norm(exact, axis=2).max()
    picked = 0
    for row in range(0, N_TIMES, 6):
        found = picked_at(browser, row, places[row].mean(axis=0))
        if found is None:  # seen from its edge
            continue
        picked += 1
        node = int(np.flatnonzero(MESH.node_ids == found["node"])[0])
        assert np.abs(found["displacement"] - exact[row, node]).max() < 1e-4 * largest
        assert np.abs(found["position"] - places[row, node]).max() < 1e-4 * largest + 1e-6
        assert found["fields"]["deflection"] == pytest.approx(
            np.linalg.norm(exact[row, node]), abs=1e-4 * largest
        )
    assert picked >= 3


def test_the_graphics_unit_puts_nodes_where_the_script_does(opened):
    """Colours by deflection at a large enlargement: the picture changes as the nodes do, pixel by pixel."""
    browser, *_ = opened
    browser.run("report.player.colour(''); report.player.seekRow(20); report.player.draw()")
    still = browser.picture()
    browser.run("report.player.gain = 30; report.player.draw()")
    assert (browser.picture() != still).any(axis=2).mean() > 2e-3
    browser.run("report.player.gain = 1; report.player.draw()")
    assert np.array_equal(browser.picture(), still)


@pytest.mark.parametrize("field", ["deflection", "von Mises stress"])
def test_colours_are_those_of_the_values(opened, field):
    """In the middle of triangles: the colour of their corners' mean, on the range of the run, shaded."""
    browser, *_ = opened
    seen, shares, ramp = browser.run(f"""
        const player = report.player, body = player.bodies[0], {{ camera, canvas, root }} = player.view;
        Object.keys(player.shown).forEach((name) => (player.shown[name] = false));
        player.bodies[1].group.visible = false;
        player.colour('{field}'); player.seekRow(12);
        // Near, for the value changes within a pixel.
        camera.position.multiplyScalar(0.2).add(body.placeOf(7, 1));
        player.draw(); camera.updateMatrixWorld();
        const scale = player.scene.scales['{field}'], seen = [], shares = [];
        for (let i = 0; i < body.triangles.length; i += 3) {{
          const corners = [0, 1, 2].map((k) => body.triangles[i + k]);
          const at = body.placeOf(corners[0], 1);
          at.add(body.placeOf(corners[1], 1)).add(body.placeOf(corners[2], 1)).divideScalar(3);
          at.applyMatrix4(root.matrix).project(camera);
          seen.push([(at.x + 1) / 2 * canvas.clientWidth, (1 - at.y) / 2 * canvas.clientHeight]);
          const value = (node) => '{field}' === 'deflection'
            ? scale.factor * Math.hypot(...[0, 1, 2].map((c) => body.displacement.at(node, c)))
            : player.valueAt(body, '{field}', node);
          shares.push(corners.reduce((sum, node) => sum + value(node), 0) / 3 / scale.high);
        }}
        return [seen, shares, body.uniforms.ramp.value.map((each) => each.toArray())];""")
    picture = browser.picture()[..., :3].astype(float)
    columns, rows = np.array(seen).astype(int).T
    found, place = picture[rows, columns], np.array(shares) * (len(ramp) - 1)
    expected = 255 * np.stack(
        [np.interp(place, np.arange(len(ramp)), own) for own in np.transpose(ramp)], axis=1
    )
    shade = (found * expected).sum(axis=1) / (expected**2).sum(axis=1)
    assert np.abs(found - shade[:, None] * expected).max() < 4
    assert (0.4 - 0.02 <= shade).all()
    assert (shade <= 1.02).all()
    assert np.ptp(shares) > 0.1


def test_the_undeformed_outline_hides_no_edges(opened):
    """Without deflections it is not seen; with large ones it is."""
    browser, *_ = opened
    show = "const p = report.player; p.seekRow(20); p.gain = %d; p.shown.undeformed = %s; p.draw()"
    pictures = {}
    for gain in (0, 30):
        for shown in ("true", "false"):
            browser.run(show % (gain, shown))
            pictures[gain, shown] = browser.picture()
    browser.run(show % (1, "true"))
    assert np.array_equal(pictures[0, "true"], pictures[0, "false"])
    assert not np.array_equal(pictures[30, "true"], pictures[30, "false"])


def test_play_scrub_and_loop(opened):
    browser, *_ = opened
    browser.run("report.player.rate = 1; document.getElementById('play').click()")
    browser.wait("return report.player.time > 0.1")
    browser.run("document.getElementById('play').click()")
    at = browser.run("return report.player.time")
    time.sleep(0.2)
    assert browser.run("return report.player.time") == at
    browser.run(
        "const t = document.getElementById('time'); t.value = 0.5; t.dispatchEvent(new Event('input'))"
    )
    assert browser.run("return report.player.time") == pytest.approx(0.5, abs=1e-6)
    assert browser.run("return document.getElementById('now').textContent") == "t = 2.5 s"
    browser.run("report.player.seekRow(1e9)")
    assert browser.run("return report.player.frame.before") == N_TIMES - 1
    browser.run("report.player.looping = false; report.player.play(true); report.player.seek(0.999)")
    browser.wait("return !report.player.playing")
    assert browser.run("return report.player.time") == 1.0


def test_a_click_on_a_curve_sets_the_time(opened):
    browser, *_ = opened
    browser.wait("return report.curves.charts[0].line")
    over = browser.run("const { over } = report.curves.charts[0].graph; over.scrollIntoView(); return over")
    width = over.size["width"]
    webdriver.ActionChains(browser.driver).move_to_element_with_offset(
        over, -0.25 * width, 0
    ).click().perform()
    assert browser.run("return report.player.time") == pytest.approx(0.25, abs=0.02)


def test_keys_cameras_and_themes(opened):
    browser, *_ = opened
    keys = "document.dispatchEvent(new KeyboardEvent('keydown', { key: '%s' }))"
    assert browser.run("return document.documentElement.dataset.theme") == "light"
    light = browser.picture()
    browser.run(keys % "d")
    browser.wait("return !report.player.dirty")
    assert browser.run("return document.documentElement.dataset.theme") == "dark"
    assert browser.picture().mean() < light.mean() - 50
    browser.run(keys % "d")
    for key, place in (("x", 0), ("Y", 1), ("z", 2)):
        browser.run(keys % key)
        seen = np.array(browser.run("return report.player.view.camera.position.toArray()"))
        assert abs(seen[place]) > 0.99 * np.linalg.norm(seen)
        assert (seen[place] < 0) == key.isupper()
    browser.run(keys % "ArrowRight")
    assert browser.run("return report.player.row") == 1


def test_a_followed_body_stands_still(opened):
    browser, *_ = opened
    browser.run("report.player.follow(1); report.player.draw()")
    place = """
        const { bodies, view, frame } = report.player; report.player.draw();
        return bodies[1].position.clone().applyMatrix4(view.root.matrix).toArray()"""
    before = browser.run(place)
    browser.run("report.player.seekRow(30)")
    assert browser.run(place) == pytest.approx(before, abs=1e-4)


def test_deleted_elements_vanish_from_what_can_be_picked(browser, tmp_path):
    system, solution = eroding([[1, 1, 1, 1], [1, 0, 1, 1], [1, 0, 0, 1]])
    mesh = system.placed("bar").body.mesh
    browser.open(write_report(tmp_path / "run.html", system, solution, {"bar": mesh}))
    seen = [
        browser.run(f"report.player.seekRow({row}); return report.player.bodies[0].alive / 3")
        for row in range(3)
    ]
    assert seen == [36, 32, 24]
    # And from the picture: without marks and outlines, from where it stands in full, ever less is drawn.
    browser.run("const p = report.player; p.view.look('-y'); p.shown.undeformed = p.shown.edges = false")
    drawn = []
    for row in range(3):
        browser.run(f"report.player.seekRow({row}); report.player.draw()")
        picture = browser.picture()
        drawn.append(int((picture != picture[0, picture.shape[1] // 2]).any(axis=2).sum()))
    assert drawn[0] > drawn[1] > drawn[2]


def test_the_printed_page_shows_the_picture_as_it_stands(opened):
    browser, *_ = opened
    browser.run("report.player.seekRow(20)")
    printed = browser.driver.execute_cdp_cmd("Page.printToPDF", {"printBackground": False})
    assert base64.b64decode(printed["data"]).startswith(b"%PDF")
    source = browser.run("return document.getElementById('still').src")
    still = np.asarray(Image.open(io.BytesIO(base64.b64decode(source.split(",")[1]))).convert("RGBA"))
    assert len(np.unique(still.reshape(-1, 4), axis=0)) > 50
    # It takes the place of the canvas, whose contents browsers do not print.
    browser.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    for name, display in (("still", "block"), ("view", "none"), ("controls", "none")):
        style = f"getComputedStyle(document.getElementById('{name}')).display"
        assert browser.run(f"return {style}") == display
    browser.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})


def test_clips_repeat_and_have_their_own_note(browser, tmp_path, clamped_blade):
    """As modes do: the last instant leads on to the first, and the place in the period is a phase."""
    machine = moving_machine(*two_bodies(clamped_blade), {"blade": MESH})
    clips = [Clip(f"mode {k + 1}", 20 * k, 20, f"{k + 1} Hz, damping 2 %", repeats=True) for k in range(2)]
    browser.open(write_page(tmp_path / "modes.html", Page("modes", [], machine, clips)))
    choose = "const c = document.getElementById('clip'); c.value = 1; c.dispatchEvent(new Event('change'))"
    browser.run(choose)
    assert browser.run("return document.getElementById('clip-note').textContent") == "2 Hz, damping 2 %"
    assert browser.run("return report.player.frame.before") == 20
    browser.run("report.player.seek(0.975 * report.player.length)")
    frame = browser.run("return report.player.frame")
    assert (frame["before"], frame["after"]) == (39, 20)
    assert frame["share"] == pytest.approx(0.5, abs=0.01)
    assert browser.run("return document.getElementById('now').textContent") == "phase 351\u00b0"


def test_curves_of_a_campbell_diagram_are_named_at_the_pointer(browser, tmp_path):
    rates, lines = np.linspace(0.0, 2.0, 5), np.array([[2.0, 5.0]] * 5) * 2 * np.pi
    diagram = CampbellDiagram(
        rates, 1j * lines, np.ones((4, 2)), axes="that turn", names=("flap 1", "edge 1")
    )
    browser.open(write_campbell_report(tmp_path / "campbell.html", diagram, units=SI))
    for name, height in (("flap 1", 2.0), ("edge 1", 5.0)):
        script = f"""
            const {{ graph }} = report.curves.charts[0], {{ over }} = graph; over.scrollIntoView();
            const at = [graph.valToPos(graph.data[0][2], 'x'), graph.valToPos({height}, 'y')];
            return [over, at[0] - over.clientWidth / 2, at[1] - over.clientHeight / 2]"""
        over, right, down = browser.run(script)
        webdriver.ActionChains(browser.driver).move_to_element_with_offset(over, right, down + 3).perform()
        told = "const tip = report.curves.charts[0].graph.over.querySelector('.tip'); return tip.textContent"
        browser.wait(f"{told} == '{name}: {height:g}'", seconds=5.0)


def test_a_notebook_plays_it_in_a_frame(browser, tmp_path, clamped_blade):
    """Without a complaint: the policy of the page holds in its frame."""
    path = tmp_path / "notebook.html"
    shown = sp.player(*two_bodies(clamped_blade), {"blade": MESH})
    path.write_text(f"<!doctype html><p>cell</p>{shown._repr_html_()}", encoding="utf-8")
    browser.clear()
    browser.driver.get(path.as_uri())
    browser.wait("return frames.length == 1")
    browser.driver.switch_to.frame(0)
    browser.wait("return Boolean(window.report)")
    browser.run("report.player.seekRow(7)")
    assert browser.run("return report.player.row") == 7
    assert browser.complaints() == []
    assert browser.requests() == []


def test_without_graphics_the_rest_is_there(tmp_path, clamped_blade):
    system, solution = two_bodies(clamped_blade)
    path = write_report(tmp_path / "run.html", system, solution, {"blade": MESH})
    browser = Browser(tmp_path / "profile", "--disable-3d-apis")
    try:
        browser.open(path)
        assert "WebGL" in browser.run("return document.getElementById('message').textContent")
        assert browser.run("return report.curves.charts.length") == 2
        assert browser.run("return document.querySelectorAll('article table').length") >= 2
    finally:
        browser.driver.quit()


def test_a_click_on_a_beam_is_on_the_node_that_carries_it(browser, tmp_path):
    """The displacement of its node, not of its skin; no stress where it is not known."""
    system, solution, model = beam_frame()
    body, motion = system.placed("frame").body, solution.bodies["frame"]
    path = write_report(tmp_path / "run.html", system, solution, {"frame": model}, elements={"frame": model})
    browser.open(path)
    exact = deflections(body, motion, observer_of(system, solution, "frame"))
    largest = np.linalg.norm(exact, axis=2).max()
    surface = body_surface(model)
    seen = surface.positions(body, motion)
    stressed = set()
    for row in (0, 13, 31):
        for triangle in surface.skin.triangles[::7]:
            found = picked_at(browser, row, seen[row, triangle].mean(axis=0))
            if found is None:
                continue
            node = int(np.flatnonzero(model.mesh.node_ids == found["node"])[0])
            assert np.abs(found["displacement"] - exact[row, node]).max() < 1e-4 * largest
            stressed.add((node, "von Mises stress" in found["fields"]))
    assert (3, False) in stressed
    assert (0, True) in stressed
    assert (3, True) not in stressed
