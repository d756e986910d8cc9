// Puts the explorer together: the plant that is stepped, the scene, sliders, curves, and one loop that does it all.

import * as THREE from "three";
import { ink, PUSHED, twoSided } from "page/colours";
import { Hand } from "page/hand";
import { Live } from "page/live";
import { element, placeOfFactor, roundFactor, showPlaying, tell, watchLook } from "page/look";
import { Loop } from "page/loop";
import { deviation, readPlant, trajectory } from "page/reading";
import { Stage } from "page/scene";
import { choice, group, short, slider } from "page/sliders";
import { PROFILES, SHAPERS } from "page/ways";

const AXES = ["x", "y", "z"];
const AGREES = 1e-9;
const LONGEST = 0.5; // time that one frame makes up for at most [s]
const BUDGET = 0.6; // part of the time between frames that steps may take
const CURVES = 250; // milliseconds in which all curves are drawn once where frames are late
const KNOCK = 0.05; // [s]
const REST = 1e-9; // displacement that is none [m]
const DEGREES = 180 / Math.PI;
const OUTGROWN = "The motion has outgrown its steps: gains that are not stable, or a push too strong. Reset, and set them lower.";
const UNITS = { m: ["mm", 1e3], N: ["N", 1], K: ["K", 1] };

const data = readPlant();
const loop = new Loop(data);
const turn = { ...data.turn };
// drawn, curves: instants of the last drawing and of that of curves; gap: mean time between drawings [ms].
const state = { playing: false, speed: 1, owed: 0, before: 0, stale: true, limit: REST, drawn: 0, curves: 0, gap: 16 };
const defaults = [];
let away = false; // whether the last slew went there

element("made").textContent = `A reduced antenna that this page steps; made by ${data.made}`;
document.title = data.title;
let stage = null;
let hand = null;
try {
  const holder = element("stages").appendChild(Object.assign(document.createElement("div"), { className: "stage" }));
  stage = new Stage(data.mesh, holder, "");
  hand = new Hand(stage, data.hands, (push) => {
    loop.hand = push;
    state.stale = true;
    if (push) play(true);
  });
} catch (error) {
  element("stages").textContent = `This browser draws no 3-D scene (${error.message}); sliders and curves work.`;
}
tellNotes();
const live = new Live(element("curves"), loop);
fillSettings();
listen();
dress();
home();
requestAnimationFrame(frame);
performance.mark("shown");
window.explorer = {
  data, loop, stage, hand, live, state, draw, play, advance, deviation: () => deviation(data), trajectory: (asked) => trajectory(data, asked),
  ready: true,
};
if (!window.matchMedia("(prefers-reduced-motion: reduce)").matches) {
  play(true);
  slew();
}

function tellNotes() {
  const off = deviation(data);
  const agrees = off <= AGREES;
  const { elements, whole } = data.film || {};
  const watched = elements < whole ? ` Tension is watched at ${elements} of ${whole} film elements, those nearest to compression.` : "";
  const text = `${data.model.reach.length} coordinates, steps of ${short(1e3 * data.step)} ms.${watched}`;
  const found = agrees
    ? `This page steps the model itself, and agrees with Python to ${off.toExponential(0)} over a slew with a pull and a push.`
    : `This browser steps the model differently from Python (${off.toExponential(1)}): do not trust it.`;
  const stands = data.remarks.length ? ` Chosen for this page: ${data.remarks.join("; ")}.` : "";
  element("notes").textContent = `${found} ${text}${stands}`;
  element("notes").classList.toggle("wrong", !agrees);
  if (!agrees) console.error(found);
}

function fillSettings() {
  const holder = element("settings");
  if (data.pulls.length) {
    const pulls = group(holder, "Tension and other drives");
    for (const { name, number, unit, limit } of data.pulls) {
      const [shown, factor] = UNITS[unit] || [unit, 1];
      const said = (value) => `${value > 0 ? "+" : ""}${short(factor * value)} ${shown}`;
      defaults.push(slider(pulls, { name, low: -limit, high: limit, value: 0, said, set: (value) => { loop.held[number] = value; } }));
    }
  }
  const slews = group(holder, `Slew about ${AXES[data.axis]}`);
  const most = Math.min(Math.max(2 * Math.abs(turn.angle), 1), Math.PI) * (turn.angle < 0 ? -1 : 1);
  defaults.push(
    slider(slews, { name: "angle", low: 0, high: most, value: turn.angle, said: (value) => `${short(DEGREES * value)}°`, set: (value) => { turn.angle = value; } }),
    slider(slews, { name: "time", low: turn.duration / 5, high: turn.duration * 5, value: turn.duration, logarithmic: true, said: (value) => `${short(value)} s`, set: (value) => { turn.duration = value; } }),
    choice(slews, { name: "profile", values: PROFILES, value: turn.profile, set: (value) => { turn.profile = value; } }),
    choice(slews, { name: `shaper for ${short(turn.frequency)} Hz`, values: SHAPERS, value: turn.shaper, set: (value) => { turn.shaper = value; } }),
  );
  const control = group(holder, "Attitude control");
  const gain = (name, key, unit) => {
    const value = loop.gains[key];
    const set = (given) => { loop.gains[key] = given; };
    const said = (given) => `${short(given)} ${unit}`;
    if (value > 0) defaults.push(slider(control, { name, low: value / 20, high: value * 20, value, logarithmic: true, said, set }));
  };
  gain("stiffness", "stiffness", "N m/rad");
  gain("damping", "damping", "N m s/rad");
  gain("feedforward", "inertia", "kg m²");
  const structure = group(holder, "Structure");
  const { frequency, ratio } = data.lowest;
  const said = (factor) => `${short(100 * ratio * factor, 2)} % at ${short(frequency)} Hz`;
  defaults.push(slider(structure, { name: "damping", low: 0.1, high: 100, value: 1, logarithmic: true, said, set: (factor) => { if (factor !== loop.plant.factor) loop.damp(factor); } }));
}

function play(playing) {
  if (playing && loop.plant.failed) return;
  state.playing = playing;
  state.before = state.drawn = performance.now();
  state.stale = true;
}

function restart() {
  loop.restart();
  live.clear();
  away = false;
  state.stale = true;
}

// There and back.
function slew() {
  const angle = away ? -loop.ways.reduce((sum, way) => sum + way.angle, 0) : turn.angle;
  loop.slew({ ...turn, angle });
  away = !away;
  play(true);
}

function knock() {
  loop.knock(data.hands.first + data.hands.knock, data.hands.strength, KNOCK);
  play(true);
}

// As many steps as time has passed, but no more than a frame has room for.
function advance(now) {
  const passed = Math.min(Math.max(0, now - state.before) / 1000, LONGEST);
  state.before = now;
  state.owed += passed * state.speed;
  const start = performance.now();
  while (state.owed >= data.step && !loop.plant.failed) {
    loop.advance();
    state.owed -= data.step;
    if (loop.steps > 0) continue;
    live.note();
    if (performance.now() - start > 1000 * BUDGET * Math.max(passed, 1 / 60)) state.owed = Math.min(state.owed, data.step);
  }
  if (loop.plant.failed) state.playing = false;
  state.stale = true;
}

function factor() {
  return roundFactor(element("magnification").value);
}

// Puts the structure where the coordinates say.
function place() {
  const { points, values, mesh } = stage;
  const { q } = loop.plant;
  const by = factor();
  let largest = 0;
  for (let i = 0, at = 0; i < points.length; i++) {
    let moved = 0;
    for (let k = 0; k < q.length; k++, at++) moved += data.shapes[at] * q[k];
    points[i] = mesh.nodes[i] + by * moved;
    if (i % 3 !== 2) continue;
    values[(i - 2) / 3] = moved;
    if (Math.abs(moved) > largest) largest = Math.abs(moved);
  }
  // Colours follow the largest displacement of the last seconds.
  state.limit = Math.max(0.99 * state.limit, largest, REST);
  const turned = element("view").value === "inertial" ? loop.plant.angle : 0;
  stage.turn(about(turned));
}

function about(angle) {
  return new THREE.Quaternion().setFromAxisAngle(new THREE.Vector3().setComponent(data.axis, 1), angle);
}

// The next of 1, 2, 5, 10, ...
function round(value) {
  const base = 10 ** Math.floor(Math.log10(value));
  return [1, 2, 5, 10].map((digit) => digit * base).find((each) => each >= value * 0.999);
}

function draw() {
  tell(element("clock"), `${loop.time.toFixed(2)} s`);
  tell(element("factor"), `× ${factor()}`);
  tell(element("slew"), away ? "Slew back" : "Slew");
  showPlaying(element("play"), state.playing);
  tell(element("trouble"), loop.plant.failed ? OUTGROWN : "");
  const now = performance.now();
  state.gap += 0.1 * (Math.min(now - state.drawn, 200) - state.gap);
  state.drawn = now;
  if (stage) {
    stage.sharpen(state.playing);
    place();
    const limit = round(state.limit);
    stage.paintDisplacement(limit, data.film);
    stage.netLines.visible = element("lines").checked;
    tell(stage.said, `displacements × ${factor()}`);
    hand.draw();
    stage.draw();
    const moved = state.limit > REST;
    tell(element("low"), moved ? `w = −${short(1e3 * limit)} mm` : "w = 0");
    tell(element("high"), moved ? `+${short(1e3 * limit)} mm` : "at rest");
  }
  // Curves that move cost more than the scene where the processor draws: there one panel is drawn at a time.
  const fast = !state.playing || state.gap < 20;
  if (fast || now - state.curves >= CURVES / live.plots.length) {
    state.curves = now;
    live.draw(fast);
    tellFilm();
  }
}

// Whether the film is in tension, in words; a state that stays is not said again to those who listen.
function tellFilm() {
  const { film } = data;
  if (!film) return;
  const { lowest, pushed } = live;
  const now = film.least < 0;
  const state = now ? "In compression: there a real film wrinkles, and this elastic one does not." : "In tension everywhere.";
  const numbers = now
    ? `${short(100 * film.share)} % of its area, least ${short(film.least)} N/m`
    : `Least ${short(film.least)} N/m, until now ${short(lowest[0])} N/m at ${lowest[1].toFixed(2)} s`;
  const before = pushed.length && !now ? `; it was in compression between ${pushed[0].toFixed(2)} and ${pushed.at(-1).toFixed(2)} s` : "";
  tell(element("film-state"), state);
  tell(element("film-numbers"), `${numbers}${before}.`);
  element("film").classList.toggle("wrong", now);
  element("pushed").hidden = !now;
}

function frame(now) {
  if (state.playing) advance(now);
  if ((stage && stage.controls.update()) || state.stale) {
    state.stale = false;
    draw();
  }
  requestAnimationFrame(frame);
}

function dress() {
  if (!stage) return;
  stage.dress();
  stage.cables.paint(null, ink("--cable"));
}

function home() {
  state.stale = true;
  if (!stage) return;
  stage.fit();
  const turned = element("view").value === "inertial" ? turn.angle : 0;
  stage.home([0, 0.5, 1].map((part) => about(part * turned)), 0.12 * data.mesh.span);
}

function listen() {
  const again = () => { state.stale = true; };
  element("pushed").querySelector("i").style.background = PUSHED;
  element("legend").querySelector(".bar").style.background = twoSided.gradient;
  element("magnification").value = placeOfFactor(data.magnification);
  for (const id of ["magnification", "lines"]) element(id).addEventListener("input", again);
  element("play").addEventListener("click", () => play(!state.playing));
  element("reset").addEventListener("click", restart);
  element("slew").addEventListener("click", slew);
  element("knock").addEventListener("click", knock);
  element("knock").disabled = !data.hands.nodes.length;
  element("defaults").addEventListener("click", () => {
    for (const put of defaults) put();
    again();
  });
  element("speed").addEventListener("input", () => { state.speed = Number(element("speed").value); });
  element("view").addEventListener("input", home);
  element("home").addEventListener("click", home);
  if (stage) {
    stage.controls.addEventListener("change", again);
    new ResizeObserver(() => {
      stage.fit();
      again();
    }).observe(stage.holder);
  }
  watchLook(() => {
    if (stage) stage.fit();
    dress();
    draw();
  });
  document.addEventListener("keydown", keyed);
}

function keyed(event) {
  const { target, key } = event;
  if (event.ctrlKey || event.metaKey || event.altKey || target.tagName === "SELECT") return;
  if (target.tagName === "INPUT" && target.type === "range" && key.startsWith("Arrow")) return;
  const magnify = (by) => {
    element("magnification").value = String(Number(element("magnification").value) + by);
    state.stale = true;
  };
  const actions = {
    " ": () => play(!state.playing), s: slew, k: knock, r: restart, Home: home,
    ArrowUp: () => magnify(0.02), ArrowDown: () => magnify(-0.02),
  };
  const action = actions[key.length === 1 ? key.toLowerCase() : key];
  if (!action) return;
  event.preventDefault();
  action();
}
