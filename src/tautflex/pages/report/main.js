// Puts the page together: stages, controls, curves, and one loop that draws what has changed.

import { rising, STATES, twoSided } from "page/colours";
import { showFacts } from "page/facts";
import { Heat } from "page/heat";
import { element, placeOfFactor, roundFactor, showPlaying, tell, watchLook } from "page/look";
import { Player } from "page/player";
import { Plot } from "page/plot";
import { RunStage } from "page/run_stage";
import { readRuns } from "page/runs";

const MODE_SIZE = 0.07; // part of the span that a mode's largest displacement is drawn with

const data = readRuns();
const { runs } = data;
element("made").textContent = `${runs.length > 1 ? `Two runs, ${runs.map((run) => run.name).join(" beside ")}` : "A run"}; page by ${data.made}`;
document.title = data.title;

let stages = [];
try {
  stages = runs.map((run) => {
    const holder = element("stages").appendChild(Object.assign(document.createElement("div"), { className: "stage" }));
    return new RunStage(run, holder, runs.length > 1);
  });
} catch (error) {
  element("stages").textContent = `This browser draws no 3-D scene (${error.message}); curves and numbers are below.`;
}

const plots = [];
let stale = true;
const player = new Player(runs, () => {
  stale = true;
});

fillControls();
showCurves();
showFrequencies();
showFacts(element("facts"), runs);
element("notes").textContent = runs
  .flatMap((run) => [...run.notes, ...unknown(run)].map((note) => (runs.length > 1 ? `${run.name}: ${note}` : note)))
  .map((note) => `${note[0].toUpperCase()}${note.slice(1)}.`)
  .join(" ");
listen();
home();
loop();
performance.mark("shown");
window.report = { player, stages, draw, ready: true };
if (!window.matchMedia("(prefers-reduced-motion: reduce)").matches) player.toggle(true);

function option(holder, value, text) {
  holder.append(Object.assign(document.createElement("option"), { value, textContent: text }));
}

// What the page cannot tell, and why.
function unknown({ modes_missing: modes, fields_missing: fields }) {
  if (modes && modes === fields) return [`modes, tension and wrinkles are not known: ${modes}`];
  return [["modes are", modes], ["tension and wrinkles are", fields]].filter(([, why]) => why).map(([what, why]) => `${what} not known: ${why}`);
}

function fillControls() {
  option(element("motion"), "run", "the run");
  const most = runs.reduce((one, run) => (run.modes.length > one.modes.length ? run : one), runs[0]);
  const names = (k) => runs.filter((run) => run.modes[k]).map((run) => run.modes[k].name).join(" | ");
  most.modes.forEach((_, k) => option(element("motion"), String(k), `mode ${k + 1}: ${names(k)}`));
  if (!most.modes.length) {
    option(element("motion"), "", "modes: not known");
    element("motion").lastChild.disabled = true;
  }
  option(element("colour"), "w", "displacement w");
  const having = (key) => runs.every((run) => run.frames[key]);
  if (having("tension")) option(element("colour"), "tension", "cable tension");
  if (having("state")) option(element("colour"), "state", "state of the film");
  element("magnification").value = placeOfFactor(Math.min(...runs.map((run) => run.magnification)));
  [element("time").min, element("time").max] = [player.first, player.last];
}

function factor() {
  return roundFactor(element("magnification").value);
}

// The curves of all runs that have one name in one panel; of two runs the second is dashed.
function showCurves() {
  const keys = [...new Set(runs.flatMap((run) => run.curves.map((panel) => panel.key)))];
  const instants = runs.flatMap((run) => run.curves.flatMap((panel) => panel.lines.flatMap(({ x }) => [x[0], x[x.length - 1]])));
  const span = [Math.min(...instants), Math.max(...instants)];
  for (const key of keys) {
    const found = runs.map((run) => run.curves.find((panel) => panel.key === key));
    const { title, label } = found.find((panel) => panel);
    const lines = found.flatMap((panel, number) =>
      (panel ? panel.lines : []).map((line, colour) => ({
        ...line, colour, dash: number, name: runs.length > 1 ? `${line.name}, ${runs[number].name}` : line.name, key: true,
      })),
    );
    const until = Math.max(...runs.map((run) => run.maneuver_end));
    plots.push(new Plot(element("curves"), { title, labelX: "t [s]", labelY: label, lines, seek: (time) => player.seek(time), until, span }));
  }
}

function showFrequencies() {
  const having = runs.filter((run) => run.frequencies);
  const lines = having.map((run, number) => ({
    ...run.frequencies.spectrum, colour: 0, dash: number, key: true,
    name: `${run.frequencies.probe}${runs.length > 1 ? `, ${run.name}` : ""}`,
  }));
  if (lines.length) {
    const marks = having.flatMap((run) => run.modes.map((mode) => mode.frequency));
    const title = having[0].frequencies.of + (marks.length ? ", dotted: natural frequencies" : "");
    const options = { title, labelX: "f [Hz]", labelY: "amplitude of w [mm]", lines, logY: true, tall: true, marks };
    new Plot(element("frequencies"), options);
  }
  for (const run of having) {
    const title = `Scalogram of w at ${run.frequencies.probe}${runs.length > 1 ? `, ${run.name}` : ""}`;
    plots.push(new Heat(element("frequencies"), title, run.frequencies.scalogram, (time) => player.seek(time)));
  }
}

function turning() {
  return player.mode === null && element("view").value === "inertial";
}

function home() {
  for (const stage of stages) {
    stage.fit();
    stage.home(turning(), factor());
  }
  stale = true;
}

function limits() {
  if (player.mode !== null) return [0, MODE_SIZE * Math.max(...runs.map((run) => run.mesh.span))];
  if (element("colour").value !== "tension") return [0, Math.max(...runs.map((run) => run.frames.largest))];
  const found = runs.map((run) => run.frames.tension_limits);
  return [Math.min(...found.map(([low]) => low)), Math.max(...found.map(([, high]) => high))];
}

function showLegend(by, [low, high]) {
  const text = `${by} ${player.mode} ${low} ${high}`;
  if (showLegend.text === text) return;
  showLegend.text = text;
  const legend = element("legend");
  legend.replaceChildren();
  if (by === "state") {
    for (const [name, colour] of STATES) {
      const chip = legend.appendChild(Object.assign(document.createElement("span"), { className: "chip" }));
      chip.append(Object.assign(document.createElement("i"), { style: `background: ${colour}` }), name);
    }
    return;
  }
  const three = (value) => String(Number(value.toPrecision(3))).replace("-", "−");
  const ends = by === "w" ? [`w = −${three(1e3 * high)} mm`, `+${three(1e3 * high)} mm`] : [`tension ${three(low)} N`, `${three(high)} N`];
  if (by === "w" && !high) [ends[0], ends[1]] = ["w = 0", "all the time"];
  if (player.mode !== null) [ends[0], ends[1]] = ["mode shape: −1", "+1"];
  const bar = Object.assign(document.createElement("span"), { className: "bar" });
  bar.style.background = by === "w" ? twoSided.gradient : rising.gradient;
  legend.append(ends[0], bar, ends[1]);
}

function draw() {
  const by = player.mode === null ? element("colour").value : "w";
  const time = player.shown;
  const ends = limits();
  for (const stage of stages) {
    stage.sharpen(player.playing);
    const mode = player.mode === null || stage.run.modes[player.mode] ? player.mode : null;
    if (mode === null) stage.showRun(time, factor(), turning());
    else stage.showMode(mode, MODE_SIZE * stage.run.mesh.span * Math.sin(player.phase));
    stage.paint(by, ends);
    stage.netLines.visible = element("lines").checked;
    tell(stage.said, mode === null ? `t = ${time.toFixed(3)} s, displacements × ${factor()}` : `mode ${mode + 1}: ${stage.run.modes[mode].name}, slowed to be seen`);
    stage.draw();
  }
  showLegend(by, ends);
  tell(element("clock"), player.mode === null ? `${time.toFixed(3)} s` : "mode");
  element("time").value = String(time);
  tell(element("factor"), `× ${factor()}`);
  element("motion").value = player.mode === null ? "run" : String(player.mode);
  showPlaying(element("play"), player.playing);
  for (const plot of plots) plot.tell(time);
}

function loop() {
  let moved = false;
  for (const stage of stages) moved = stage.controls.update() || moved;
  if (stale || moved) {
    stale = false;
    draw();
  }
  requestAnimationFrame(loop);
}

function listen() {
  const again = () => {
    stale = true;
  };
  for (const id of ["colour", "magnification", "lines"]) element(id).addEventListener("input", again);
  element("play").addEventListener("click", () => player.toggle());
  element("time").addEventListener("input", () => player.seek(Number(element("time").value)));
  element("speed").addEventListener("input", () => {
    player.speed = Number(element("speed").value);
  });
  element("view").addEventListener("input", home);
  element("home").addEventListener("click", home);
  element("motion").addEventListener("input", () => {
    const { value } = element("motion");
    const before = player.mode;
    player.choose(value === "run" ? null : Number(value));
    if ((before === null) !== (player.mode === null)) home();
    player.toggle(true);
  });
  for (const stage of stages) {
    stage.controls.addEventListener("change", () => {
      for (const other of stages) {
        if (other === stage) continue;
        other.camera.position.copy(stage.camera.position);
        other.controls.target.copy(stage.controls.target);
        other.camera.quaternion.copy(stage.camera.quaternion);
      }
      again();
    });
    new ResizeObserver(() => {
      stage.fit();
      again();
    }).observe(stage.holder);
  }
  watchLook(() => {
    for (const stage of stages) {
      stage.fit();
      stage.dress();
      stage.painted = undefined;
    }
    draw();
  });
  document.addEventListener("keydown", keyed);
}

function keyed(event) {
  if (event.ctrlKey || event.metaKey || event.altKey || ["SELECT", "TEXTAREA"].includes(event.target.tagName)) return;
  if (event.target.tagName === "INPUT" && event.target.type === "range" && event.key !== " ") return;
  const magnify = (by) => {
    element("magnification").value = String(Number(element("magnification").value) + by);
    stale = true;
  };
  const actions = {
    " ": () => player.toggle(), ArrowLeft: () => player.step(-1), ArrowRight: () => player.step(1),
    ArrowUp: () => magnify(0.02), ArrowDown: () => magnify(-0.02), Home: home,
  };
  const action = actions[event.key];
  if (!action) return;
  if (event.target.tagName === "BUTTON" || event.key !== "Enter") event.preventDefault();
  action();
}
