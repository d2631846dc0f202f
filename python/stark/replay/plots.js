// Small line plots on 2D canvases, all with the same time axis and a cursor at the time on show.

const PLOT_COLORS = ["#2f6fde", "#e0663f", "#2a9d8f", "#9b6bd0", "#d9a021", "#5f6b7a", "#c2387f", "#5d8f1f"];

// Colours that do not repeat: a small palette, then hues by the golden angle, each as far as can be from those before.
function plotColor(i) {
  if (i < PLOT_COLORS.length) return PLOT_COLORS[i];
  return `hsl(${((i - PLOT_COLORS.length) * 137.508 + 20) % 360}, 62%, ${[34, 58, 46][i % 3]}%)`;
}

// All plots, those of another run over the first ones as dashed lines of the same colours.
function makePlots(parent, header, seek) {
  const { time, plots } = header.telemetry, other = header.overlay;
  const charts = plots.map((spec) => {
    const same = other && other.plots.find((plot) => plot.title === spec.title);
    return new Plot(parent, spec, time, seek, same && { ...same, time: other.time });
  });
  if (other) {
    const legend = byId("overlay-legend");
    legend.hidden = false;
    element("i", "", "", legend);
    legend.append("this run");
    element("i", "dashed", "", legend);
    legend.append(other.name);
  }
  return charts;
}

function shortNumber(value, digits = 3) {
  if (value === null || value === undefined) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e5 || size < 1e-3) return value.toExponential(digits - 2).replace("e+", "e").replace("-", "−").replace("e-", "e−");
  return String(Number(value.toPrecision(digits))).replace("-", "−");
}

class Plot {
  constructor(parent, spec, time, seek, overlay) {
    this.time = time;
    this.spec = spec;
    this.begin = Math.min(time[0], overlay && overlay.time.length ? overlay.time[0] : Infinity);
    this.end = Math.max(time[time.length - 1], overlay && overlay.time.length ? overlay.time[overlay.time.length - 1] : -Infinity);
    this.lines = spec.series.map((series, i) => ({ ...series, time, color: plotColor(i), shown: true, dashed: false }));
    for (const series of overlay ? overlay.series : []) {
      let i = spec.series.findIndex((own) => own.label === series.label);
      if (i < 0) i = this.lines.length;
      this.lines.push({ ...series, time: overlay.time, color: plotColor(i), shown: true, dashed: true });
    }
    this.hideGiants();
    const box = element("div", "plot", "", parent), title = element("div", "title", "", box);
    element("b", "", spec.title, title);
    element("i", "", [spec.unit, spec.scale === "log" ? "log" : ""].filter(Boolean).join(", "), title);
    this.value = element("span", "", "", title);
    this.canvas = element("canvas", "", "", box);
    if (spec.series.length > 1) this.legend(element("div", "legend", "", box));
    const seekAt = (event) => {
      const area = this.canvas.getBoundingClientRect();
      const f = (event.clientX - area.left - this.left) / Math.max(1, area.width - this.left - 2);
      seek(this.begin + Math.min(1, Math.max(0, f)) * (this.end - this.begin));
    };
    this.canvas.addEventListener("pointerdown", (event) => {
      this.canvas.setPointerCapture(event.pointerId);
      seekAt(event);
    });
    this.canvas.addEventListener("pointermove", (event) => event.buttons && seekAt(event));
    this.left = 48;
    this.range();
  }

  // A series that would flatten all others is left to be switched on.
  hideGiants() {
    const span = ({ values }) => {
      const known = values.filter((v) => v !== null);
      return known.length ? Math.max(...known.map(Math.abs)) : 0;
    };
    const own = this.lines.filter((line) => !line.dashed).map((line) => [span(line), line.label]).sort((a, b) => b[0] - a[0]);
    if (this.spec.scale === "log" || own.length < 2 || own[0][0] < 8 * own[1][0] || own[1][0] === 0) return;
    for (const line of this.lines) if (line.label === own[0][1]) line.shown = false;
  }

  legend(parent) {
    for (const label of new Set(this.lines.map((line) => line.label))) {
      const own = this.lines.filter((line) => line.label === label), item = element("button", "", "", parent);
      element("i", "", "", item).style.background = own[0].color;
      item.append(label);
      item.title = "Show or hide " + label;
      item.classList.toggle("off", !own[0].shown);
      item.addEventListener("click", () => {
        for (const line of own) line.shown = !line.shown;
        item.classList.toggle("off", !own[0].shown);
        this.range();
        this.back = null;
        this.draw(this.now);
      });
    }
  }

  range() {
    const log = this.spec.scale === "log";
    const values = this.lines.filter((line) => line.shown).flatMap((line) => line.values).filter((v) => v !== null && (!log || v > 0));
    this.map = (v) => (log ? Math.log10(v) : v);
    let low = Infinity, high = -Infinity;
    for (const v of values) {
      low = Math.min(low, this.map(v));
      high = Math.max(high, this.map(v));
    }
    if (!values.length) [low, high] = [0, 1];
    if (!log && low > 0 && low < 0.6 * high) low = 0;
    if (!log && low < 0 && -low < 1e-3 * high) low = 0;
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
    const t0 = this.begin, span = this.end - t0 || 1;
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
    for (const line of this.lines.filter((entry) => entry.shown)) {
      c.strokeStyle = line.color;
      c.lineWidth = line.dashed ? 1.2 : 1.5;
      c.setLineDash(line.dashed ? [4, 3] : []);
      c.lineJoin = "round";
      c.beginPath();
      let down = false;
      line.values.forEach((v, k) => {
        if (v === null || (log && v <= 0)) {
          down = false;
          return;
        }
        c[down ? "lineTo" : "moveTo"](this.x(line.time[k]), y(this.map(v)));
        down = true;
      });
      c.stroke();
    }
  }

  draw(now) {
    this.now = now;
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
