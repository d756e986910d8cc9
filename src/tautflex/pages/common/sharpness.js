// How many of the screen's pixels a scene is drawn with: fewer, step by step, while frames are late; all when it stands still.

import { drawnBySoftware } from "page/software";

const PARTS = [1, 0.8, 0.6]; // of the pixels along each side
const FRAME = 1000 / 60; // [ms]
const LATE = 1.2 * FRAME; // a clock of 60 frames a second is not exact
const COUNT = 9; // frames that are looked at
const LONGEST = 400; // a pause, not a frame [ms]

export class Sharpness {
  constructor() {
    this.level = 0;
    this.gap = FRAME; // between frames, median of the last ones [ms]
    this.sure = drawnBySoftware; // that fewer pixels take less time
    this.rest();
  }

  // It stands still; when it moves again it tries to be one step sharper than before.
  rest() {
    if (this.before === null) return;
    this.before = null;
    this.gaps = [];
    this.level = Math.max(0, this.level - 1);
    this.helps = true;
    this.coarser = null;
  }

  // Part of the pixels for a frame that is drawn at an instant [ms], as one of a motion.
  moving(now) {
    if (this.before !== null && now - this.before < LONGEST) this.gaps.push(now - this.before);
    this.before = now;
    if (this.gaps.length === COUNT) {
      this.gap = this.gaps.sort((one, other) => one - other)[COUNT >> 1];
      this.gaps = [];
      this.judge();
    }
    return PARTS[this.level];
  }

  // Frames that are late for another reason than their pixels get them back.
  judge() {
    if (!this.sure && this.coarser !== null && this.gap > 0.95 * this.coarser) {
      this.level -= 1;
      this.helps = false;
    }
    this.coarser = null;
    if (!this.helps || this.gap <= LATE || this.level === PARTS.length - 1) return;
    this.coarser = this.gap;
    this.level += 1;
  }
}
