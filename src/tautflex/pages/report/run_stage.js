// The structure of one run, where it is at an instant, or as it moves in a mode.

import * as THREE from "three";
import { colourOf, ink, states, twoSided } from "page/colours";
import { placed } from "page/data";
import { Stage } from "page/scene";

export class RunStage extends Stage {
  constructor(run, holder, several) {
    super(run.mesh, holder, several ? run.name : "");
    this.run = run;
  }

  home(turning, factor) {
    const { frames } = this.run;
    const some = turning ? Array.from({ length: 24 }, (_, k) => Math.round((k / 23) * (frames.time.length - 1))) : [];
    const turns = some.map((frame) => quaternion(frames.attitude, frame));
    super.home(turning ? turns : [new THREE.Quaternion()], factor * frames.largest);
  }

  // Puts the structure where it is at a time [s].
  showRun(time, factor, turning) {
    const { frames, mesh } = this.run;
    const { values, scale } = frames.displacement;
    const [frame, part] = placed(frames.time, time);
    const size = this.points.length;
    const one = frame * size;
    const next = Math.min(frame + 1, frames.time.length - 1) * size;
    for (let i = 0; i < size; i++) {
      const moved = (values[one + i] + part * (values[next + i] - values[one + i])) * scale[i % 3];
      this.points[i] = mesh.nodes[i] + factor * moved;
      if (i % 3 === 2) this.values[(i - 2) / 3] = moved;
    }
    this.frame = part < 0.5 ? frame : Math.min(frame + 1, frames.time.length - 1);
    if (!turning) {
      this.turn(new THREE.Quaternion());
      return;
    }
    const now = quaternion(frames.attitude, frame);
    if (next > one) now.slerp(quaternion(frames.attitude, frame + 1), part);
    this.turn(now, quaternion(frames.attitude, 0));
  }

  showMode(number, amplitude) {
    const { mesh, modes } = this.run;
    const { values, scale } = modes[number].shape;
    for (let i = 0; i < this.points.length; i++) {
      const moved = amplitude * values[i] * scale[i % 3];
      this.points[i] = mesh.nodes[i] + moved;
      if (i % 3 === 2) this.values[(i - 2) / 3] = moved;
    }
    this.turn(new THREE.Quaternion());
  }

  // Paints by "w" within a limit, by "state" or by "tension" within two.
  paint(by, limits) {
    const { mesh, frames } = this.run;
    const offset = this.frame * (mesh.triangles.length / 3);
    if (by === "w") this.paintDisplacement(limits[1] || 1);
    else if (by === "state") this.paintFilm(states, (k) => Math.min(frames.state[offset + Math.floor(k / 3)], 2));
    else this.paintFilm(twoSided.table, () => colourOf(0, -1, 1));
    if (by === "tension") {
      const { count } = this.cables;
      this.paintCables(frames.tension.subarray(this.frame * count, (this.frame + 1) * count), limits);
    } else if (this.painted !== by) this.cables.paint(null, ink("--cable"));
    this.cables.radius = (by === "tension" ? 0.0035 : 0.0016) * mesh.span;
    this.painted = by;
  }
}

function quaternion(rows, number) {
  return new THREE.Quaternion(rows[4 * number + 1], rows[4 * number + 2], rows[4 * number + 3], rows[4 * number]);
}
