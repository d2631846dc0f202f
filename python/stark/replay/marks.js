// What lies over the picture: forces of contact, the picked point, the scale of colours. All on one 2D canvas.

const FORCE_COLOR = "#cc1721", INK = "#1d2530", LONGEST = 0.3; // of an arrow of the usual largest force, over the scene's radius
const PREFIXES = { "-4": "p", "-3": "n", "-2": "µ", "-1": "m", 0: "", 1: "k", 2: "M", 3: "G", 4: "T" };

// Numbers as texts with a common prefix of their unit: [0, 2500], "Pa" are ["0", "2.5"], "kPa".
function withPrefix(values, unit) {
  const largest = Math.max(...values.map(Math.abs));
  let power = 0;
  if (["Pa", "N", "m/s"].includes(unit) && largest > 0)
    power = Math.min(unit === "m/s" ? 0 : 4, Math.max(-4, Math.floor(Math.log10(largest * (1 + 1e-12)) / 3)));
  return [values.map((v) => shortNumber(v / Math.pow(1000, power))), PREFIXES[power] + unit];
}

function forceText(force) {
  const [[text], unit] = withPrefix([force], "N");
  return `${text} ${unit}`;
}

class Marks {
  constructor(canvas, bounds) {
    this.canvas = canvas;
    this.bounds = bounds;
  }

  begin(matrix) {
    const ratio = devicePixelRatio, { clientWidth: width, clientHeight: height } = this.canvas;
    const fits = this.canvas.width === Math.round(width * ratio) && this.canvas.height === Math.round(height * ratio);
    if (!fits) [this.canvas.width, this.canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
    [this.width, this.height, this.matrix] = [width, height, matrix];
    const c = (this.context = this.canvas.getContext("2d"));
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    c.clearRect(0, 0, width, height);
    c.font = "12px system-ui, sans-serif";
    c.textBaseline = "middle";
    c.lineCap = "round";
  }

  // Pixel of a point, null behind the camera.
  project(p) {
    const m = this.matrix, at = (r) => m[r] * p[0] + m[4 + r] * p[1] + m[8 + r] * p[2] + m[12 + r], w = at(3);
    return w > 1e-9 ? [(0.5 + (0.5 * at(0)) / w) * this.width, (0.5 - (0.5 * at(1)) / w) * this.height] : null;
  }

  arrow(from, to) {
    const c = this.context, dx = to[0] - from[0], dy = to[1] - from[1], length = Math.hypot(dx, dy);
    if (length < 0.5 || length > 1e4) return;
    const head = Math.min(9, 0.6 * length), ux = dx / length, uy = dy / length, neck = [to[0] - head * ux, to[1] - head * uy];
    for (const [width, color] of [[4, "rgba(255, 255, 255, 0.75)"], [2, FORCE_COLOR]]) {
      c.strokeStyle = color;
      c.lineWidth = width;
      c.beginPath();
      c.moveTo(...from);
      c.lineTo(...neck);
      c.stroke();
    }
    c.fillStyle = FORCE_COLOR;
    c.beginPath();
    c.moveTo(...to);
    c.lineTo(neck[0] - 0.42 * head * uy, neck[1] + 0.42 * head * ux);
    c.lineTo(neck[0] + 0.42 * head * uy, neck[1] - 0.42 * head * ux);
    c.fill();
  }

  dot(at, radius, color) {
    const c = this.context;
    c.beginPath();
    c.arc(at[0], at[1], radius, 0, 2 * Math.PI);
    c.fillStyle = color;
    c.fill();
    c.strokeStyle = "rgba(255, 255, 255, 0.85)";
    c.lineWidth = 1.2;
    c.stroke();
  }

  // Contacts of frame k: a dot where bodies touch, an arrow for the force on the body that moves freely, of two such on the
  // first one; with `on`, those of this body only and on it.
  contacts(contacts, k, bodies, clip, on) {
    const scale = (LONGEST * this.bounds.radius) / (contacts.usual || 1);
    let drawn = 0;
    for (let i = contacts.starts[k]; i < contacts.starts[k + 1]; ++i) {
      const a = bodies[contacts.pairs[2 * i]], b = bodies[contacts.pairs[2 * i + 1]];
      if (!(a.visible || b.visible) || (on && a !== on && b !== on)) continue;
      const place = [0, 1, 2].map((c) => contacts.points[3 * i + c]);
      if (dot3(clip, place) > clip[3]) continue;
      const turned = on ? a !== on : a.motion !== "dynamic" && b.motion === "dynamic";
      const force = [0, 1, 2].map((c) => (turned ? -1 : 1) * contacts.forces[3 * i + c]), size = Math.hypot(...force);
      const length = scale * Math.min(1, (4 * contacts.usual) / (size || 1)); // a few may be much larger than all others
      const start = this.project(place), end = this.project(place.map((c, axis) => c + length * force[axis]));
      if (!start || !end) continue;
      this.dot(start, 2.6, FORCE_COLOR);
      if (size > 1e-3 * contacts.usual) this.arrow(start, end);
      drawn += 1;
    }
    if (contacts.usual > 0) this.key(contacts.usual, scale);
    return drawn;
  }

  // An arrow as long as one of a round force in the middle of the scene.
  key(usual, scale) {
    const power = Math.pow(10, Math.floor(Math.log10(usual))), force = [5, 2, 1].map((m) => m * power).find((f) => f <= usual) || power;
    const { center } = this.bounds, m = this.matrix, w = m[3] * center[0] + m[7] * center[1] + m[11] * center[2] + m[15];
    const pixels = (0.5 * this.height * scale * force * Math.hypot(m[1], m[5], m[9])) / w;
    if (!(w > 0) || pixels < 3 || pixels > 0.6 * this.width) return;
    const x = 16, y = this.height - 20, words = forceText(force), c = this.context;
    c.fillStyle = "rgba(255, 255, 255, 0.72)";
    c.fillRect(x - 8, y - 12, pixels + 22 + c.measureText(words).width, 24);
    this.arrow([x, y], [x + pixels, y]);
    c.fillStyle = INK;
    c.textAlign = "left";
    c.fillText(words, x + pixels + 8, y);
  }

  point(place) {
    const at = this.project(place), c = this.context;
    if (!at) return;
    this.dot(at, 4.5, "#2f6fde");
    c.strokeStyle = "#2f6fde";
    c.lineWidth = 1.5;
    c.beginPath();
    c.arc(at[0], at[1], 9, 0, 2 * Math.PI);
    c.stroke();
  }

  // The scale of colours: upright at the right border, lying at the upper one of a narrow view.
  colorbar(field, points) {
    const c = this.context, [low, high] = field.limits, narrow = this.width < 560;
    const shares = narrow ? [0, 0.5, 1] : [0, 0.25, 0.5, 0.75, 1];
    const [texts, unit] = withPrefix(shares.map((s) => low + s * (high - low)), field.unit);
    const title = unit ? `${field.label} [${unit}]` : field.label;
    const titled = c.measureText(title).width, texted = Math.max(...texts.map((t) => c.measureText(t).width));
    const long = narrow ? Math.max(150, titled) : Math.round(Math.min(260, 0.5 * this.height));
    const width = narrow ? long : Math.max(24 + texted, titled), left = Math.round(this.width - width - (narrow ? 28 : 24));
    const top = narrow ? 40 : Math.round(0.5 * (this.height - long) + 12);
    c.fillStyle = "rgba(255, 255, 255, 0.78)";
    c.fillRect(left - (narrow ? 20 : 10), top - 34, width + (narrow ? 40 : 20), narrow ? 68 : long + 46);
    const end = narrow ? [left + long, top] : [left, top], begin = narrow ? [left, top] : [left, top + long];
    const ramp = c.createLinearGradient(...begin, ...end), size = narrow ? [long, 12] : [14, long];
    points.forEach((rgb, i) => ramp.addColorStop(i / (points.length - 1), hexColor(rgb)));
    c.fillStyle = ramp;
    c.fillRect(left, top, ...size);
    c.fillStyle = INK;
    c.textAlign = "left";
    c.fillText(title, left, top - (narrow ? 12 : 20));
    c.strokeStyle = "rgba(29, 37, 48, 0.5)";
    c.lineWidth = 1;
    c.strokeRect(left + 0.5, top + 0.5, size[0] - 1, size[1] - 1);
    c.textAlign = narrow ? "center" : "left";
    shares.forEach((share, i) => {
      const x = narrow ? left + share * long : left + 14, y = narrow ? top + 12 : top + long * (1 - share);
      c.beginPath();
      c.moveTo(x, y);
      c.lineTo(narrow ? x : x + 4, narrow ? y + 4 : y);
      c.stroke();
      c.fillText(texts[i], narrow ? x : x + 8, narrow ? y + 12 : y);
    });
  }
}
