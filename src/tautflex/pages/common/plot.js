// Panel with curves: over time with a cursor that follows the player and moves it, or over frequency.

import { drawAxes, followed, line, MARGIN, scale, sized, trace, written } from "page/axes";
import { ink } from "page/colours";
import { placed } from "page/data";
import { tell } from "page/look";

const DASHES = [[], [6, 4]];

export class Plot {
  // lines: {name, x, y, colour (number), dash (number)}; seek: called with a place on the x axis; span: ends of that axis.
  constructor(holder, { title, labelX, labelY, lines, logX, logY, seek, tall, marks, until, span }) {
    this.lines = lines;
    this.options = { labelX, labelY, logX, logY, marks: marks || [], until, span };
    this.element = holder.appendChild(document.createElement("div"));
    this.element.className = `plot card${tall ? " tall" : ""}`;
    const heading = this.element.appendChild(document.createElement("h2"));
    heading.append(title);
    if (lines.length > 1 || lines[0].key) heading.append(this.keys());
    const place = this.element.appendChild(document.createElement("div"));
    place.className = "canvas";
    this.canvas = place.appendChild(document.createElement("canvas"));
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", `${title}: ${labelY} over ${labelX}`);
    this.cursor = place.appendChild(Object.assign(document.createElement("div"), { className: "cursor" }));
    this.reading = heading.appendChild(Object.assign(document.createElement("span"), { className: "reading" }));
    this.read = lines.map(({ colour }) => {
      const value = this.reading.appendChild(document.createElement("span"));
      value.style.color = `var(--line-${colour % 8})`;
      this.reading.append(" ");
      return value;
    });
    this.reading.append((/\[(.*)\]/.exec(labelY) || [])[1] || "");
    this.reading.hidden = this.cursor.hidden = true;
    this.limits();
    this.listen(seek);
    followed(this.canvas, () => this.draw());
  }

  keys() {
    const keys = Object.assign(document.createElement("span"), { className: "keys" });
    for (const each of this.lines) {
      const key = keys.appendChild(Object.assign(document.createElement("span"), { textContent: each.name }));
      key.style.setProperty("--key", `var(--line-${each.colour % 8})`);
      key.style.setProperty("--dash", each.dash ? "dashed" : "solid");
    }
    return keys;
  }

  limits() {
    const extent = (key, logarithmic) => {
      let [low, high] = [Infinity, -Infinity];
      for (const each of this.lines) {
        for (const value of each[key]) {
          if (logarithmic && value <= 0) continue;
          if (value < low) low = value;
          if (value > high) high = value;
        }
      }
      return low <= high ? [low, high] : [0, 1];
    };
    this.x = this.options.span || extent("x", this.options.logX);
    let [low, high] = extent("y", this.options.logY);
    if (this.options.logY) [low, high] = [Math.max(low, 1e-5 * high), 1.5 * high];
    else {
      const pad = 0.06 * (high - low) || 0.5 * Math.abs(high) || 1;
      [low, high] = [low - pad, high + pad];
    }
    this.y = [low, high];
  }

  listen(seek) {
    const where = (event) => this.atX.value(event.clientX - this.canvas.getBoundingClientRect().left);
    const inside = (value) => Math.min(Math.max(value, this.x[0]), this.x[1]);
    this.canvas.addEventListener("pointermove", (event) => {
      if (seek && event.buttons === 1) seek(inside(where(event)));
      else if (!seek) this.tell(inside(where(event)));
    });
    if (!seek) return;
    this.canvas.addEventListener("pointerdown", (event) => {
      this.canvas.setPointerCapture(event.pointerId);
      seek(inside(where(event)));
    });
  }

  draw() {
    const { context, width, height } = sized(this.canvas);
    if (width < 80) return;
    const { left, right, top, bottom } = MARGIN;
    const { labelX, labelY, logX, logY, marks, until } = this.options;
    const x = scale(...this.x, left, width - right, logX);
    const y = scale(...this.y, height - bottom, top, logY);
    [this.atX, this.atY] = [x, y];
    if (until > this.x[0] && until <= this.x[1]) {
      context.globalAlpha = 0.35;
      context.fillStyle = ink("--rule");
      context.fillRect(left, top, x(until) - left, height - top - bottom);
      context.globalAlpha = 1;
    }
    drawAxes(context, width, height, x, y, labelX, labelY);
    context.save();
    context.beginPath();
    context.rect(left, top, width - left - right, height - top - bottom);
    context.clip();
    context.strokeStyle = ink("--soft");
    context.setLineDash([2, 3]);
    for (const mark of marks) if (mark >= this.x[0] && mark <= this.x[1]) line(context, x(mark), top, x(mark), height - bottom);
    context.lineWidth = 1.5;
    context.lineJoin = "round";
    for (const each of this.lines) {
      context.strokeStyle = ink(`--line-${each.colour % 8}`);
      context.setLineDash(DASHES[each.dash || 0]);
      context.beginPath();
      trace(context, each.x, each.y, x, logY ? (value) => y(Math.max(value, this.y[0])) : y);
      context.stroke();
    }
    context.restore();
    if (this.shown !== undefined) this.tell(this.shown);
  }

  // Sets the cursor, and reads all curves there.
  tell(value) {
    this.shown = value;
    if (!this.atX) return;
    const pixel = this.atX(Math.min(Math.max(value, this.x[0]), this.x[1]));
    this.cursor.hidden = value < this.x[0] - 1e-9 || value > this.x[1] + 1e-9;
    this.reading.hidden = false;
    this.cursor.style.transform = `translateX(${pixel}px)`;
    this.lines.forEach(({ x, y }, n) => {
      const [k, part] = placed(x, value);
      const known = Math.abs(pixel - this.atX(Math.min(Math.max(value, x[0]), x[x.length - 1]))) < 1;
      tell(this.read[n], known ? written(Number((y[k] + part * ((y[k + 1] ?? y[k]) - y[k])).toPrecision(4))) : "–");
    });
  }
}
