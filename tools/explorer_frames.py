"""Time that a frame of the explorer takes, by the page's own clock and in processor time of the browser.

    python tools/explorer_frames.py docs/_static/explorer_m2.html

Stretches that play alternate with ones where a dot moves and nothing else is drawn, and with ones that stand still;
medians are printed. What the dot takes is the browser's own: it puts the window together anew at every frame. A frame
of 60 a second has 16.7 ms.
"""

from __future__ import annotations

import argparse
import shutil
import statistics
from pathlib import Path
from typing import Any

from playwright.sync_api import Page, sync_playwright

SOFTWARE = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
# Frames as the page draws them, one after the other, with a clock that goes on by a sixtieth of a second.
PARTS = """(count) => {
  const { loop, live, stage, hand, state, draw, advance } = window.explorer;
  const gl = stage.renderer.getContext();
  const pixel = new Uint8Array(4);
  const taken = { steps: [], script: [], drawn: [] };
  state.playing = true;
  state.gap = 16;
  state.owed = 0;
  let now = 0;
  state.before = 0;
  for (let k = 0; k < count; k++) {
    now += 1000 / 60;
    const start = performance.now();
    advance(now);
    const stepped = performance.now();
    state.drawn = performance.now() - 16;
    draw();
    const asked = performance.now();
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
    taken.steps.push(stepped - start);
    taken.script.push(asked - start);
    taken.drawn.push(performance.now() - start);
  }
  state.playing = false;
  return taken;
}"""

# A frame of the browser alone: a dot moves, and the page draws nothing.
BARE = """() => {
  const { stage, live, state } = window.explorer;
  const own = [stage.draw.bind(stage), live.draw.bind(live)];
  stage.draw = () => window.bare || own[0]();
  live.draw = (all) => window.bare || own[1](all);
  const dot = document.body.appendChild(document.createElement("div"));
  dot.style.cssText = "position: fixed; left: 0; top: 0; width: 9px; height: 9px; background: red";
  const tick = () => {
    window.count += state.playing;
    if (state.playing && window.bare) dot.style.left = `${window.count % 50}px`;
    if (state.playing && !window.bare) window.part = stage.part;
    requestAnimationFrame(tick);
  };
  tick();
}"""


def processor_times(session: Any) -> dict[str, float]:
    """Processor time of each kind of process of the browser until now [s]."""
    found: dict[str, float] = {}
    for one in session.send("SystemInfo.getProcessInfo")["processInfo"]:
        found[one["type"]] = found.get(one["type"], 0.0) + one["cpuTime"]
    return found


def stretch(page: Page, session: Any, seconds: float, *, playing: bool) -> tuple[dict[str, float], int]:
    """Processor time of the processes [s] and frames drawn over a stretch of time."""
    page.evaluate("(playing) => { window.explorer.play(playing); window.count = 0; }", playing)
    before = processor_times(session)
    page.wait_for_timeout(1e3 * seconds)
    after, frames = processor_times(session), page.evaluate("window.count")
    page.evaluate("window.explorer.play(false)")
    return {kind: after[kind] - before.get(kind, 0.0) for kind in after}, int(frames)


def measured(page: Page, session: Any, seconds: float, pairs: int) -> None:
    """Print what a frame takes."""
    page.evaluate("window.explorer.loop.slew({...window.explorer.data.turn, angle: 0.5})")
    page.evaluate(PARTS, 1500)  # a window full of curves, compiled code
    rounds = [page.evaluate(PARTS, 120) for _ in range(7)]
    words = {"steps": "steps of the model", "script": "steps and script of drawing", "drawn": "until all is drawn"}
    print("page's clock, ms a frame: median of rounds (best)")
    for key, text in words.items():
        means = [statistics.median(one[key]) for one in rounds]
        print(f"  {text:<28} {statistics.median(means):6.2f} ({min(means):.2f})")
    page.evaluate(BARE)
    found: dict[str, dict[str, list[float]]] = {"all": {}, "a dot alone": {}}
    rate = []
    for _ in range(pairs):
        for name, kinds in found.items():
            page.evaluate("(bare) => { window.bare = bare; }", name != "all")
            moving, frames = stretch(page, session, seconds, playing=True)
            still, _ = stretch(page, session, seconds, playing=False)
            if name == "all":
                rate.append(frames / seconds)
            for kind in moving:
                kinds.setdefault(kind, []).append(1e3 * (moving[kind] - still.get(kind, 0.0)) / max(frames, 1))
    part = page.evaluate("window.part")
    print(f"{statistics.median(rate):.0f} frames a second, with {part:g} of the pixels along each side of the scene")
    print("processor time beyond standing still, ms a frame: all, and a dot alone")
    for kind in found["all"]:
        print(f"  {kind:<28}", *(f"{statistics.median(kinds[kind]):6.2f}" for kinds in found.values()))


def main() -> None:
    """Open a page and measure."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("page", type=Path)
    parser.add_argument("--seconds", type=float, default=3.0, help="length of a stretch")
    parser.add_argument("--pairs", type=int, default=5)
    asked = parser.parse_args()
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=shutil.which("chromium"), args=SOFTWARE)
        page = browser.new_page(viewport={"width": 1280, "height": 820}, reduced_motion="reduce")
        page.goto(asked.page.resolve().as_uri())
        page.wait_for_function("(window.explorer || {}).ready")
        measured(page, browser.new_browser_cdp_session(), asked.seconds, asked.pairs)
        browser.close()


if __name__ == "__main__":
    main()
