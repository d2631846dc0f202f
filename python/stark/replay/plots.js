// Small line plots on 2D canvases, all with the same time axis and a cursor at the time on show.

const PLOT_COLORS = ["#2f6fde", "#e0663f", "#2a9d8f", "#9b6bd0", "#d9a021", "#5f6b7a"];

function shortNumber(value, digits = 3) {
  if (value === null || value === undefined) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e5 || size < 1e-3) return value.toExponential(digits - 2).replace("e+", "e").replace("-", "−").replace("e-", "e−");
  return String(Number(value.toPrecision(digits))).replace("-", "−");
}

class Plot {
  constructor(parent, spec, time, seek) {
    this.spec = spec;
    this.time = time;
    const make = (tag, className, text, inside) => {
      const element = document.createElement(tag);
      if (className) element.className = className;
      if (text) element.textContent = text;
      inside.append(element);
      return element;
    };
    const box = make("div", "plot", "", parent), title = make("div", "title", "", box);
    make("b", "", spec.title, title);
    make("i", "", [spec.unit, spec.scale === "log" ? "log" : ""].filter(Boolean).join(", "), title);
    this.value = make("span", "", "", title);
    this.canvas = make("canvas", "", "", box);
    if (spec.series.length > 1) {
      const legend = make("div", "legend", "", box);
      spec.series.forEach((series, i) => {
        const item = make("span", "", "", legend);
        make("i", "", "", item).style.background = PLOT_COLORS[i % PLOT_COLORS.length];
        item.append(series.label);
      });
    }
    const seekAt = (event) => {
      const area = this.canvas.getBoundingClientRect();
      const f = (event.clientX - area.left - this.left) / Math.max(1, area.width - this.left - 2);
      seek(time[0] + Math.min(1, Math.max(0, f)) * (time[time.length - 1] - time[0]));
    };
    this.canvas.addEventListener("pointerdown", (event) => {
      this.canvas.setPointerCapture(event.pointerId);
      seekAt(event);
    });
    this.canvas.addEventListener("pointermove", (event) => event.buttons && seekAt(event));
    this.left = 48;
    this.range();
  }

  range() {
    const log = this.spec.scale === "log";
    const values = this.spec.series.flatMap((s) => s.values).filter((v) => v !== null && (!log || v > 0));
    this.map = (v) => (log ? Math.log10(v) : v);
    let low = Infinity, high = -Infinity;
    for (const v of values) {
      low = Math.min(low, this.map(v));
      high = Math.max(high, this.map(v));
    }
    if (!values.length) [low, high] = [0, 1];
    if (!log && low > 0 && low < 0.6 * high) low = 0;
    if (log) [low, high] = [Math.floor(low + 1e-9), Math.ceil(high - 1e-9)];
    if (high - low < 1e-12) high = low + (log ? 1 : Math.abs(low) || 1);
    [this.low, this.high] = [low, high];
  }

  // Draws the lines into a picture of their own; moving the cursor only copies it.
  prepare(width, height, ratio) {
    const back = (this.back = document.createElement("canvas"));
    back.width = width * ratio;
    back.height = height * ratio;
    const c = back.getContext("2d");
    c.scale(ratio, ratio);
    c.font = "11px system-ui, sans-serif";
    c.textBaseline = "middle";
    c.textAlign = "right";
    const log = this.spec.scale === "log";
    const y = (v) => height - 7 - ((v - this.low) / (this.high - this.low)) * (height - 14);
    const t0 = this.time[0], span = this.time[this.time.length - 1] - t0 || 1;
    this.x = (t) => this.left + ((t - t0) / span) * (width - this.left - 2);
    for (const f of [0, 0.5, 1]) {
      const v = this.low + f * (this.high - this.low);
      c.strokeStyle = "#e8ebef";
      c.lineWidth = 1;
      c.beginPath();
      c.moveTo(this.left, Math.round(y(v)) + 0.5);
      c.lineTo(width, Math.round(y(v)) + 0.5);
      c.stroke();
      if (f === 0.5 && log && v % 1) continue;
      c.fillStyle = "#8a94a1";
      c.fillText(shortNumber(log ? Math.pow(10, v) : v, 2), this.left - 6, y(v));
    }
    this.spec.series.forEach((series, i) => {
      c.strokeStyle = PLOT_COLORS[i % PLOT_COLORS.length];
      c.lineWidth = 1.5;
      c.lineJoin = "round";
      c.beginPath();
      let down = false;
      series.values.forEach((v, k) => {
        if (v === null || (log && v <= 0)) {
          down = false;
          return;
        }
        c[down ? "lineTo" : "moveTo"](this.x(this.time[k]), y(this.map(v)));
        down = true;
      });
      c.stroke();
    });
  }

  draw(now) {
    const ratio = devicePixelRatio, width = this.canvas.clientWidth, height = this.canvas.clientHeight;
    if (!width) return;
    if (!this.back || this.back.width !== Math.floor(width * ratio) || this.back.height !== Math.floor(height * ratio)) {
      this.prepare(width, height, ratio);
      this.canvas.width = this.back.width;
      this.canvas.height = this.back.height;
    }
    const c = this.canvas.getContext("2d");
    c.clearRect(0, 0, this.canvas.width, this.canvas.height);
    c.drawImage(this.back, 0, 0);
    const x = Math.round(this.x(now) * ratio) + 0.5;
    c.strokeStyle = "rgba(29, 37, 48, 0.55)";
    c.lineWidth = Math.max(1, ratio);
    c.beginPath();
    c.moveTo(x, 0);
    c.lineTo(x, this.canvas.height);
    c.stroke();
    let k = this.time.findIndex((t) => t >= now - 1e-9);
    if (k < 0) k = this.time.length - 1;
    if (this.spec.series.length === 1) this.value.textContent = shortNumber(this.spec.series[0].values[k]);
  }
}
