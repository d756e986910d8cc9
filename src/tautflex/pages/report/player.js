// What is shown at which time: runs along their clock, or a mode to and fro.

const STRETCH = 2.0; // seconds that a mode takes to and fro, whatever its frequency

export class Player {
  constructor(runs, changed) {
    this.runs = runs;
    this.changed = changed;
    this.first = Math.min(...runs.map((run) => run.frames.time[0]));
    this.last = Math.max(...runs.map((run) => run.frames.time[run.frames.time.length - 1]));
    this.time = this.first;
    this.phase = 0;
    this.speed = 1;
    this.mode = null;
    this.playing = false;
    this.drawn = 0;
    this.tick = this.tick.bind(this);
  }

  toggle(playing = !this.playing) {
    if (playing === this.playing) return;
    this.playing = playing;
    if (playing && this.mode === null && this.time >= this.last) this.time = this.first;
    this.before = performance.now();
    if (playing) requestAnimationFrame(this.tick);
    this.changed();
  }

  tick(now) {
    if (!this.playing) return;
    const passed = Math.min(Math.max(0, now - this.before) / 1000, 0.25);
    this.before = now;
    if (this.mode === null) {
      this.time += this.speed * passed;
      // The end is looked at for a moment, then it begins anew.
      if (this.time > this.last + 0.8 * this.speed) this.time = this.first;
    } else this.phase += (2 * Math.PI * passed) / STRETCH;
    this.drawn += 1;
    this.changed();
    requestAnimationFrame(this.tick);
  }

  get shown() {
    return Math.min(this.time, this.last);
  }

  seek(time) {
    this.mode = null;
    this.time = Math.min(Math.max(time, this.first), this.last);
    this.changed();
  }

  step(count) {
    const time = this.runs[0].frames.time;
    this.toggle(false);
    this.seek(this.shown + (count * (this.last - this.first)) / Math.max(1, time.length - 1));
  }

  choose(mode) {
    this.mode = mode;
    this.phase = Math.PI / 2;
    this.changed();
  }
}
