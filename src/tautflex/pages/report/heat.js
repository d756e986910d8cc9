// Scalogram: amplitude over time and frequency as a picture, its ridge, and the cone inside which it is to be trusted.

import { drawAxes, followed, MARGIN, scale, sized } from "page/axes";
import { colourOf, ink, rising } from "page/colours";

export class Heat {
  constructor(holder, title, map, seek) {
    this.map = map;
    this.element = holder.appendChild(document.createElement("div"));
    this.element.className = "plot card tall heat";
    const heading = this.element.appendChild(document.createElement("h2"));
    heading.append(title);
    const largest = map.magnitude.reduce((most, value) => Math.max(most, value), 0);
    const key = heading.appendChild(Object.assign(document.createElement("span"), { className: "keys" }));
    key.append(`0 to ${Number(largest.toPrecision(3))} mm; white line: ridge; grey: ends matter`);
    const place = this.element.appendChild(Object.assign(document.createElement("div"), { className: "canvas" }));
    this.canvas = place.appendChild(document.createElement("canvas"));
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", title);
    this.cursor = place.appendChild(Object.assign(document.createElement("div"), { className: "cursor" }));
    this.picture = this.paint(largest);
    this.canvas.addEventListener("pointerdown", (event) => this.seek(event, seek));
    this.canvas.addEventListener("pointermove", (event) => event.buttons === 1 && this.seek(event, seek));
    followed(this.canvas, () => this.draw());
  }

  seek(event, seek) {
    const { time } = this.map;
    const value = this.x.value(event.clientX - this.canvas.getBoundingClientRect().left);
    seek(Math.min(Math.max(value, time[0]), time[time.length - 1]));
  }

  paint(largest) {
    const { frequency, time, magnitude } = this.map;
    const picture = document.createElement("canvas");
    [picture.width, picture.height] = [time.length, frequency.length];
    const pixels = new ImageData(time.length, frequency.length);
    for (let row = 0; row < frequency.length; row++) {
      for (let column = 0; column < time.length; column++) {
        const place = colourOf(magnitude[row * time.length + column], 0, largest);
        const at = 4 * ((frequency.length - 1 - row) * time.length + column);
        pixels.data.set(rising.table.subarray(3 * place, 3 * place + 3), at);
        pixels.data[at + 3] = 255;
      }
    }
    picture.getContext("2d").putImageData(pixels, 0, 0);
    return picture;
  }

  draw() {
    const { context, width, height } = sized(this.canvas);
    if (width < 80) return;
    const { left, right, top, bottom } = MARGIN;
    const { frequency, time, ridge, cone } = this.map;
    const [first, last] = [time[0], time[time.length - 1]];
    const y = scale(frequency[0], frequency[frequency.length - 1], height - bottom, top, true);
    this.x = scale(first, last, left, width - right, false);
    drawAxes(context, width, height, this.x, y, "t [s]", "frequency [Hz]");
    context.imageSmoothingEnabled = true;
    context.drawImage(this.picture, left, top, width - left - right, height - top - bottom);
    context.save();
    context.beginPath();
    context.rect(left, top, width - left - right, height - top - bottom);
    context.clip();
    context.fillStyle = "rgba(120, 126, 134, 0.55)";
    context.beginPath();
    context.moveTo(left, height - bottom);
    for (let k = 0; k < time.length; k++) context.lineTo(this.x(time[k]), y(Math.max(cone[k], frequency[0])));
    context.lineTo(width - right, height - bottom);
    context.fill();
    context.strokeStyle = "#ffffff";
    context.lineWidth = 1.5;
    context.beginPath();
    let drawing = false;
    for (let k = 0; k < time.length; k++) {
      if (Number.isFinite(ridge[k])) {
        if (drawing) context.lineTo(this.x(time[k]), y(ridge[k]));
        else context.moveTo(this.x(time[k]), y(ridge[k]));
      }
      drawing = Number.isFinite(ridge[k]);
    }
    context.stroke();
    context.restore();
    context.strokeStyle = ink("--soft");
    context.strokeRect(left, top, width - left - right, height - top - bottom);
    if (this.shown !== undefined) this.tell(this.shown);
  }

  tell(value) {
    this.shown = value;
    if (!this.x) return;
    const { time } = this.map;
    this.cursor.style.transform = `translateX(${this.x(Math.min(Math.max(value, time[0]), time[time.length - 1]))}px)`;
  }
}
