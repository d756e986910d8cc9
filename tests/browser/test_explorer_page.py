"""The explorer in a real browser: it steps the plant as Python does, is pushed, slewed, fits, and keeps up."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import tautflex as tf
from browser.conftest import picture, settle
from tautflex.pages.board import board_of
from tautflex.pages.explorable import explorable
from tautflex.pages.played import Turn, played
from verification.dynamic_cases import small_antenna

pytestmark = pytest.mark.slow

DAMPING = (0.2, 1e-3)
DRIVES = {
    "torque": tf.HubTorque("x", limit=4.0, rate=60.0, lag=0.03, delay=0.02, resolution=1e-3, momentum=1.5),
    "pull_x": tf.Actuator(effect=tf.TensionGroup("x", command="tension"), limit=0.1, rate=1.0),
    "pull_y": tf.Actuator(effect=tf.TensionGroup("y", command="tension"), limit=0.1, lag=0.1),
}


def bent(model):
    """The film curved, so that its model has forces of second degree and a hub that feels them."""
    nodes = model.nodes.copy()
    nodes[:, 2] = 0.05 * nodes[:, 0] ** 2 + 0.03 * nodes[:, 0] * nodes[:, 1]
    return replace(model, nodes=nodes)


def asked(kind, factor=1.0):
    """What pages and plants of this module are made from."""
    model = small_antenna() if kind == "flat" else bent(small_antenna())
    state = tf.equip(
        tf.solve_prestress(model, check=kind == "flat"), [DRIVES[name].effect for name in ("pull_x", "pull_y")]
    )
    damping = tf.Rayleigh(*(factor * value for value in DAMPING))
    hub = tf.FreeHub(20.0, (3.0, 4.0, 5.0), axes="x" if kind == "flat" else "y")
    drives = DRIVES | {"torque": replace(DRIVES["torque"], axis=hub.axes)}
    rom = tf.reduce(state, tf.ModalBasis(count=5, directions=("z", "rx", "ry")))
    return (rom,), {"hub": hub, "actuators": drives, "damping": damping, "slew": tf.Slew(0.3, 0.8, axis=AXIS[kind])}


AXIS = {"flat": (1.0, 0.0, 0.0), "curved": (0.0, 1.0, 0.0)}


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    given, options = asked("flat")
    return tf.explore(*given, tmp_path_factory.mktemp("page") / "explorer.html", **options)


def drawn_settings(seed, board):
    """Sliders and pushes at random, as the page and Python take them."""
    chance = np.random.default_rng(seed)
    turn = Turn(
        float(chance.uniform(-0.8, 0.8)), float(chance.uniform(0.2, 0.9)),
        str(chance.choice(["versine", "minimum-jerk", "bang-bang"])), str(chance.choice(["none", "ZV", "ZVD"])),
        float(chance.uniform(2.0, 8.0)), 0.02,
    )  # fmt: skip
    gains = {"stiffness": float(chance.uniform(3, 40)), "damping": float(chance.uniform(3, 30)), "inertia": 4.0}
    held = {1: float(chance.uniform(-0.1, 0.1)), 2: float(chance.uniform(-0.1, 0.1))}
    knocks = [
        {"number": board.first_hand + int(chance.integers(len(board.hands))), "force": float(chance.normal(0, 2e-3)),
         "start": start, "end": start + 0.07}
        for start in (0.1, 0.4)
    ]  # fmt: skip
    return {"turn": turn, "gains": gains, "held": held, "knocks": knocks, "count": 120}


@pytest.mark.parametrize("kind", ["flat", "curved"])
def test_the_page_steps_the_plant_as_python_does(opened, page, kind, tmp_path, verification_row):
    if kind == "curved":
        given, options = asked(kind)
        page = tf.explore(*given, tmp_path / "curved.html", **options)
    shown, worst = opened(page), 0.0
    assert shown.page.evaluate("window.explorer.deviation()") < 1e-12
    for seed, factor in enumerate((1.0, 0.3, 8.0)):
        given, options = asked(kind, factor)
        board = board_of(explorable(*given, **options))
        model = board.constants[0]
        assert (model.quadratic.size > 0) == (kind == "curved"), "both kinds of forces are tried"
        settings = drawn_settings(seed, board)
        expected = played(board.plant, **settings)
        assert not board.plant.failed[0]
        asking = settings | {"turn": settings["turn"]._asdict(), "damping": factor}
        found = np.array(shown.page.evaluate("(asked) => window.explorer.trajectory(asked)", asking))
        assert found.shape == expected.shape
        worst = max(worst, float((np.abs(found - expected).max(axis=0) / np.abs(expected).max(axis=0)).max()))
    assert worst < 1e-9
    verification_row(f"explorer page, {kind} antenna: measurements over 1.2 s", 0.0, worst, "CompiledPlant")


def test_opens_from_disk_plays_and_slews(opened, page):
    assert page.stat().st_size <= 2e6
    shown = opened(page)
    page, before = shown.page, picture(shown.page, ".stage canvas")
    assert shown.said == []
    assert {url.split(":")[0] for url in shown.asked} <= {"file", "data", "blob"}
    assert len(np.unique(before.reshape(-1, 3) // 16, axis=0)) > 60, "the scene is blank"
    assert "agrees with Python" in page.locator("#notes").text_content()
    page.locator("#slew").click()
    page.wait_for_function("window.explorer.loop.time > 0.3", timeout=60_000)
    page.keyboard.press("r")  # from the button: a letter is a key of the page there too
    page.keyboard.press(" ")
    settle(page)
    assert page.evaluate("window.explorer.loop.ways.length") == 0
    page.keyboard.press("s")
    page.wait_for_function("window.explorer.loop.time > 0.5", timeout=60_000)
    page.locator("#play").click()
    settle(page)
    assert not page.evaluate("window.explorer.state.playing")
    assert page.evaluate("window.explorer.loop.plant.angle") > 0.01
    assert np.abs(picture(page, ".stage canvas") - before).mean() > 0.5
    assert page.locator("#slew").text_content() == "Slew back"
    page.locator("#reset").click()
    settle(page)
    assert page.locator("#clock").text_content() == "0.00 s"
    assert page.evaluate("window.explorer.loop.plant.angle") == 0.0


def test_what_is_drawn_is_what_is_measured(opened, page):
    """The watched node of a flat film stands where its sensor reads, magnified; the hub is turned by its angle."""
    page = opened(page).page
    drawn, factor, measured, angle, x = page.evaluate(
        """() => {
          const { loop, stage, data, draw } = window.explorer;
          loop.slew({ ...data.turn, angle: 0.4 });
          for (let k = 0; k < 300; k++) loop.advance();
          draw();
          const node = data.mesh.probes.nodes[0];
          const factor = Number(document.getElementById("factor").textContent.split(" ")[1]);
          const moved = stage.points[3 * node + 2] - data.mesh.nodes[3 * node + 2];
          return [moved, factor, loop.measured[data.seen.w[0]], loop.plant.angle, stage.body.quaternion.x];
        }"""
    )
    assert abs(measured) > 1e-6
    assert drawn == pytest.approx(factor * measured, rel=2e-3)
    assert x == pytest.approx(np.sin(0.5 * angle), abs=1e-12)


def test_sliders_and_the_hand_act(opened, page):
    page = opened(page).page
    pull, gain, damping = (page.locator("#settings input").nth(n) for n in (0, 4, 7))
    for each, place in ((pull, "1"), (gain, "0"), (damping, "1")):
        each.evaluate("(input, place) => { input.value = place; input.dispatchEvent(new Event('input')); }", place)
    loop = page.evaluate("({ held: Array.from(explorer.loop.held.slice(0, 3)), factor: explorer.loop.plant.factor })")
    assert loop["held"] == pytest.approx([0.0, 0.1, 0.0])
    assert loop["factor"] == pytest.approx(100.0)
    default = page.evaluate("window.explorer.data.gains.stiffness")
    assert page.evaluate("window.explorer.loop.gains.stiffness") == pytest.approx(default / 20.0)
    assert page.locator("#settings output").first.text_content() == "+0.1 N"
    page.locator("#defaults").click()
    assert page.evaluate("window.explorer.loop.gains.stiffness") == default
    assert page.evaluate("Math.max(...window.explorer.loop.held)") == 0.0
    # The place that is pushed first, near the middle of the picture.
    box = page.locator(".stage").bounding_box()
    at = page.evaluate(
        """() => {
          const { hand, stage } = window.explorer;
          const seen = hand.nodes.map((node) => {
            const point = stage.camera.position.clone().fromArray(stage.points, 3 * node);
            return hand.seen(point);
          });
          const away = seen.map(([x, y]) => Math.hypot(x - stage.width / 2, y - stage.height / 2));
          return seen[away.indexOf(Math.min(...away))];
        }"""
    )
    page.mouse.move(box["x"] + at[0], box["y"] + at[1])
    page.mouse.down()
    page.mouse.move(box["x"] + at[0], box["y"] + at[1] - 60, steps=4)
    force = page.evaluate("window.explorer.loop.hand.force")
    assert force == pytest.approx(page.evaluate("window.explorer.hand.share * window.explorer.hand.strength"))
    assert force > 0.0, "up is up"
    page.wait_for_function("window.explorer.loop.time > 0.2", timeout=60_000)
    assert page.evaluate("window.explorer.hand.arrow.visible")
    page.mouse.up()
    assert page.evaluate("window.explorer.loop.hand") is None
    assert page.evaluate("Math.max(...window.explorer.loop.plant.q.map(Math.abs))") > 0.0


def test_a_film_that_pushes_is_told_and_marked(opened, page):
    """In numbers, in words, in the picture and over time; a slew too fast compresses the film, at rest it is taut."""
    page = opened(page).page
    assert page.locator("#film-state").text_content() == "In tension everywhere."
    assert page.evaluate("window.explorer.data.film.deviation()") < 1e-12
    page.evaluate("window.explorer.live.look(); window.explorer.draw()")
    before = picture(page, ".stage canvas")
    least, noted, share = page.evaluate(
        """() => {
          const { loop, live, data, draw } = window.explorer;
          const hold = { number: data.hands.first + data.hands.knock, force: 40 * data.hands.strength };
          for (let k = 0; k < 100 && !(live.lowest[0] < 0); k++) {
            loop.hand = hold;
            do loop.advance(); while (loop.steps);
            live.note();
          }
          draw();
          const { y } = live.plots[1].lines[0];
          return [data.film.least, y[y.length - 1], data.film.share];
        }"""
    )
    assert least == noted < 0.0 < share < 1.0
    settle(page)
    assert page.locator("#film-state").text_content().startswith("In compression")
    assert f"{100 * share:.3g}"[:3] in page.locator("#film-numbers").text_content()
    assert page.locator("#pushed").is_visible()
    marked = np.abs(picture(page, ".stage canvas") - [255, 212, 0]).max(axis=2) < 60
    assert marked.mean() > 1e-3 > (np.abs(before - [255, 212, 0]).max(axis=2) < 60).mean()
    page.locator("#reset").click()
    settle(page)
    assert page.locator("#film-state").text_content() == "In tension everywhere."
    assert not page.locator("#pushed").is_visible()


def test_slow_frames_do_not_slow_the_plant(opened, page):
    """Frames a fifth of a second apart still step as much as time has passed."""
    page = opened(page).page
    asked, stepped = page.evaluate(
        """() => {
          const { loop, state, advance } = window.explorer;
          state.before = 1000;
          for (let now = 1200; now <= 2000; now += 200) advance(now);
          return [1.0, loop.time + state.owed];
        }"""
    )
    assert stepped == pytest.approx(asked, abs=1e-9)


def test_late_frames_have_fewer_pixels_until_it_stands_still(opened, page):
    """Step by step, not where frames keep up, and not for long where pixels are not what takes the time."""
    page = opened(page).page
    parts = page.evaluate(
        """() => {
          const { sharpness } = window.explorer.stage;
          let now = 0;
          const moved = (gaps, sure) => {
            sharpness.sure = sure;
            const found = [];
            for (const gap of gaps) {
              for (let k = 0; k < 9; k++) found.push(sharpness.moving((now += gap)));
            }
            return [Math.max(...found), Math.min(...found), found[found.length - 1]];
          };
          const kept = moved([16.7, 17, 16.5], true);
          const late = moved([40, 35, 30, 25, 16], true);
          sharpness.rest();
          const again = moved([16.7], true);
          for (let k = 0; k < 4; k++) { sharpness.rest(); moved([16.7], true); }
          const whole = moved([16.7], true);
          return { kept, late, again, whole, vain: moved([40, 40, 40, 40, 40], false) };
        }"""
    )
    assert parts["kept"] == [1, 1, 1]
    assert parts["late"][2] == min(parts["late"]) == 0.6
    assert 0.6 < parts["again"][2] < 1, "one step sharper"
    assert parts["whole"] == [1, 1, 1]
    assert parts["vain"][1] < 1 == parts["vain"][2]
    drawn = page.evaluate(
        """() => {
          const { stage, state, draw } = window.explorer;
          const wide = () => stage.renderer.domElement.width;
          const [still, at] = [wide(), stage.sharpness];
          [at.level, state.playing] = [2, true];
          draw();
          const moving = wide();
          state.playing = false;
          draw();
          return [moving / still, wide() / still];
        }"""
    )
    assert drawn[0] == pytest.approx(0.6, abs=0.01)
    assert drawn[1] == 1.0


def test_what_outgrows_its_steps_is_told(opened, page):
    page = opened(page).page
    page.evaluate("Object.assign(window.explorer.loop.gains, { stiffness: 1e9, damping: 1e9 })")
    page.evaluate("window.explorer.loop.data.drives.limit.fill(Infinity)")
    page.evaluate("window.explorer.loop.data.drives.rate.fill(Infinity)")
    page.evaluate("window.explorer.loop.data.drives.momentum.fill(Infinity)")
    page.keyboard.press("s")
    page.wait_for_function("window.explorer.loop.plant.failed", timeout=60_000)
    page.wait_for_function("document.getElementById('trouble').textContent.includes('outgrown')")
    assert not page.evaluate("window.explorer.state.playing")


@pytest.mark.parametrize(("width", "dark"), [(1280, False), (1280, True), (390, False), (390, True)])
def test_fits_every_window(opened, page, width, dark):
    shown = opened(page, width, dark)
    page = shown.page
    assert shown.said == []
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    wide = "all => all.filter((each) => each.scrollWidth > each.clientWidth + 1).map((each) => each.outerHTML)"
    assert page.locator("main div:not(.mark), main section, main h2, main fieldset").evaluate_all(wide) == []
    assert (picture(page, "body")[5, 5].mean() < 60) == dark


def test_the_shipped_page_agrees_and_keeps_up(opened, record_property):
    """Seventeen coordinates of the antenna M2; best of some stretches, as other work only slows a page down."""
    shipped = Path(__file__).parents[2] / "docs" / "_static" / "explorer_m2.html"
    assert shipped.stat().st_size <= 2e6
    shown = opened(shipped)
    page = shown.page
    assert shown.said == []
    assert page.evaluate("window.explorer.deviation()") < 1e-12
    assert page.evaluate("window.explorer.loop.plant.size") == 17
    step, frame = page.evaluate(
        """() => {
          const { loop, draw, stage } = window.explorer;
          loop.slew({ angle: 0.3, duration: 1, profile: "versine", shaper: "none", frequency: 1, ratio: 0 });
          const best = (rounds, count, work) => {
            let found = Infinity;
            for (let round = 0; round < rounds; round++) {
              const start = performance.now();
              for (let k = 0; k < count; k++) work();
              found = Math.min(found, (performance.now() - start) / count);
            }
            return found;
          };
          const gl = stage.renderer.getContext();
          const pixel = new Uint8Array(4);
          const step = best(40, 20, () => loop.advance());
          const frame = best(12, 2, () => {
            draw();
            gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
          });
          return [step, frame];
        }"""
    )
    record_property("step_ms", step)
    record_property("frame_ms", frame)
    share = page.evaluate("1000 / 60 / (1000 * window.explorer.data.step)")
    assert share * step <= 1000.0 / 60.0 / 4.0, f"steps of a frame take {share * step:.2f} ms"
    assert frame <= 1000.0 / 30.0, f"a frame that the processor draws takes {frame:.1f} ms"
