// A hand on the film: the place nearest to the pointer is pushed along z, as far as the pointer is pulled.

import * as THREE from "three";
import { ink } from "page/colours";

const REACH = 40; // pixels from the pointer to a place that it takes
const WHOLE = 0.25; // part of the scene's height that a whole push is pulled
const MOST = 1.5; // pushes at most

export class Hand {
  // hands: numbers of the command and nodes; told: called with a push {number, force} or null.
  constructor(stage, { nodes, first, strength }, told) {
    Object.assign(this, { stage, nodes, first, strength, told, held: null });
    const { span } = stage.mesh;
    this.arrow = new THREE.ArrowHelper(new THREE.Vector3(0, 0, 1), new THREE.Vector3(), span, "#ffffff");
    this.arrow.visible = false;
    // Before the film, which bulges over it.
    for (const part of [this.arrow.line, this.arrow.cone]) {
      part.material.depthTest = false;
      part.renderOrder = 1;
    }
    stage.body.add(this.arrow);
    const { holder } = stage;
    // Before the camera's own listener, which then leaves the pointer alone.
    holder.addEventListener("pointerdown", (event) => this.take(event), { capture: true });
    holder.addEventListener("pointermove", (event) => this.move(event));
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) holder.addEventListener(end, () => this.drop());
  }

  // Where a place of the structure is in the picture [pixels].
  seen(point) {
    const at = point.applyMatrix4(this.stage.body.matrixWorld).project(this.stage.camera);
    return [(0.5 * at.x + 0.5) * this.stage.width, (0.5 - 0.5 * at.y) * this.stage.height];
  }

  nearest(event) {
    const box = this.stage.holder.getBoundingClientRect();
    const [x, y] = [event.clientX - box.left, event.clientY - box.top];
    let [best, away] = [-1, REACH];
    this.nodes.forEach((node, k) => {
      const [left, top] = this.seen(new THREE.Vector3().fromArray(this.stage.points, 3 * node));
      const distance = Math.hypot(left - x, top - y);
      if (distance < away) [best, away] = [k, distance];
    });
    return best;
  }

  take(event) {
    const found = event.button === 0 && event.isPrimary ? this.nearest(event) : -1;
    if (found < 0) return;
    const point = new THREE.Vector3().fromArray(this.stage.points, 3 * this.nodes[found]);
    const [x, y] = this.seen(point.clone());
    const [right, top] = this.seen(point.add(new THREE.Vector3(0, 0, 0.1 * this.stage.mesh.span)));
    const length = Math.hypot(right - x, top - y);
    // Seen along z, up in the picture is up.
    const along = length > 4 ? [(right - x) / length, (top - y) / length] : [0, -1];
    this.held = { place: found, from: [event.clientX, event.clientY], along };
    this.stage.controls.enabled = false;
    this.stage.holder.setPointerCapture(event.pointerId);
    this.push(0);
  }

  move(event) {
    if (!this.held) {
      if (event.buttons === 0) this.stage.holder.style.cursor = this.nearest(event) < 0 ? "" : "grab";
      return;
    }
    const { from, along } = this.held;
    const pulled = (event.clientX - from[0]) * along[0] + (event.clientY - from[1]) * along[1];
    this.push(Math.min(Math.max(pulled / (WHOLE * this.stage.height), -MOST), MOST));
  }

  push(share) {
    this.share = share;
    this.told({ number: this.first + this.held.place, force: share * this.strength });
  }

  drop() {
    if (!this.held) return;
    this.held = null;
    this.stage.controls.enabled = true;
    this.told(null);
  }

  // The arrow follows the film.
  draw() {
    this.arrow.visible = this.held !== null;
    if (!this.held) return;
    const { span } = this.stage.mesh;
    this.arrow.position.fromArray(this.stage.points, 3 * this.nodes[this.held.place]);
    this.arrow.setDirection(new THREE.Vector3(0, 0, this.share < 0 ? -1 : 1));
    const length = span * (0.06 + 0.16 * Math.abs(this.share));
    this.arrow.setLength(length, 0.05 * span, 0.03 * span);
    this.arrow.setColor(ink("--accent"));
  }
}
