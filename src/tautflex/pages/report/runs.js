// Runs as the page carries them.

import { carried, decoded, numbers, unpackMesh } from "page/data";

export function readRuns() {
  const data = carried();
  for (const run of data.runs) {
    unpackMesh(run.mesh);
    const frames = run.frames;
    frames.time = decoded(frames.time).values;
    frames.attitude = decoded(frames.attitude).values;
    frames.displacement = decoded(frames.displacement);
    frames.tension = frames.tension ? numbers(frames.tension) : null;
    frames.state = frames.state ? decoded(frames.state).values : null;
    for (const mode of run.modes) mode.shape = decoded(mode.shape);
    for (const panel of run.curves) panel.lines.forEach(unpackLine);
    if (run.frequencies) {
      unpackLine(run.frequencies.spectrum);
      const map = run.frequencies.scalogram;
      for (const key of ["frequency", "time", "ridge", "cone"]) map[key] = decoded(map[key]).values;
      map.magnitude = numbers(map.magnitude);
    }
  }
  return data;
}

function unpackLine(line) {
  line.x = decoded(line.x).values;
  line.y = decoded(line.y).values;
}
