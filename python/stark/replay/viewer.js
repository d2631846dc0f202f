// The page: reads the data, then joins camera, transport, panel and plots. The address may carry a view after "#":
// t (seconds), view (oblique, front, side, top), edges=1, flat=1, grid=0, contacts=1, field=NAME, bare=1, play=1.

const byId = (id) => document.getElementById(id);
const VIEWS = { oblique: [-0.9, 0.42], front: [-Math.PI / 2, 0.08], side: [0, 0.08], top: [-Math.PI / 2, 1.5] };

class Camera {
  constructor(bounds) {
    this.bounds = bounds;
    this.fov = 0.61;
    this.reset();
  }
  reset(view = "oblique") {
    [this.azimuth, this.elevation] = VIEWS[view] || VIEWS.oblique;
    this.target = [...this.bounds.center];
    this.distance = this.fittingDistance();
  }
  // Smallest distance at which the box around the scene fills at most 85 % of the view.
  fittingDistance() {
    const { low, high, center, radius } = this.bounds, view = byId("view");
    const aspect = view.clientWidth / Math.max(1, view.clientHeight), half = 0.85 * Math.tan(this.fov / 2);
    const back = this.direction(), right = normalize3(cross3(this.up(), back)), top = cross3(back, right);
    let distance = 0.1 * radius;
    for (let corner = 0; corner < 8; ++corner) {
      const arm = center.map((c, a) => (corner & (1 << a) ? high[a] : low[a]) - c);
      const wide = Math.max(Math.abs(dot3(arm, right)) / (half * aspect), Math.abs(dot3(arm, top)) / half);
      distance = Math.max(distance, wide + dot3(arm, back));
    }
    return distance;
  }
  direction() {
    const c = Math.cos(this.elevation);
    const local = [c * Math.cos(this.azimuth), c * Math.sin(this.azimuth), Math.sin(this.elevation)];
    return alongAxes(this.bounds.axes, local);
  }
  eye() {
    return this.direction().map((d, i) => this.target[i] + this.distance * d);
  }
  up() {
    return this.bounds.axes[2];
  }
  turn(dx, dy) {
    this.azimuth -= 0.0075 * dx;
    this.elevation = Math.min(1.54, Math.max(-1.54, this.elevation + 0.0075 * dy));
  }
  move(dx, dy, height) {
    const scale = (2 * this.distance * Math.tan(this.fov / 2)) / height;
    const back = this.direction(), right = normalize3(cross3(this.up(), back)), top = cross3(back, right);
    for (let i = 0; i < 3; ++i) this.target[i] += scale * (dy * top[i] - dx * right[i]);
  }
  zoom(factor) {
    const r = this.bounds.radius;
    this.distance = Math.min(40 * r, Math.max(0.02 * r, this.distance * factor));
  }
}

// Box around a body at frame k.
function bodyBox(body, k) {
  let points = body.rest, m = IDENTITY;
  if (body.mode === "mesh") positionsAt(body, k, (points = new Float32Array(body.rest.length)));
  if (body.mode === "rigid") m = poseBetween(body, k, 0);
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < points.length; i += 3) {
    for (let a = 0; a < 3; ++a) {
      const v = m[a] * points[i] + m[4 + a] * points[i + 1] + m[8 + a] * points[i + 2] + m[12 + a];
      if (v < low[a]) low[a] = v;
      if (v > high[a]) high[a] = v;
    }
  }
  return { low, high };
}

// What the camera frames: everything that moves, and fixed bodies unless they are much larger (floors, walls).
function sceneBounds(bodies, frameCount, up) {
  const frames = [...new Set([0, 1, 2, 3, 4].map((i) => Math.round((i * (frameCount - 1)) / 4)))];
  const join = (boxes) => ({
    low: [0, 1, 2].map((a) => Math.min(...boxes.map((b) => b.low[a]))),
    high: [0, 1, 2].map((a) => Math.max(...boxes.map((b) => b.high[a]))),
  });
  const size = (box) => Math.hypot(...box.low.map((v, a) => box.high[a] - v));
  const drawn = bodies.filter((b) => b.vertices > 0);
  const moving = drawn.filter((b) => b.mode !== "fixed").flatMap((b) => frames.map((k) => bodyBox(b, k)));
  const still = drawn.filter((b) => b.mode === "fixed").map((b) => bodyBox(b, 0));
  let box = join(moving.length ? moving : still);
  const fixed = drawn.filter((b) => b.mode === "fixed");
  const near = still.filter((b) => size(b) < 2.5 * size(box));
  if (moving.length) fixed.forEach((b, i) => { b.scenery = size(still[i]) >= 2.5 * size(box); });
  box = join([box, ...near]);
  const center = box.low.map((v, a) => 0.5 * (v + box.high[a]));
  const radius = 0.5 * size(box) || 1;
  // The grid lies on the highest floor below the scene, else just under the lowest point.
  const top = ({ low, high }) => Math.max(dot3(low, up), dot3(high, up)), bottom = Math.min(dot3(box.low, up), dot3(box.high, up));
  const floors = fixed.map((b, i) => (b.scenery ? top(still[i]) : Infinity)).filter((height) => height <= bottom + 0.1 * radius);
  const ground = floors.length ? Math.max(...floors) + 5e-4 * radius : bottom - 1e-3 * radius;
  return { center, radius, ground, axes: uprightAxes(up), low: box.low, high: box.high };
}

// The sum of all grid coordinates, fitted poses and still vertices, so that a test can compare the decoded motion.
function checksum(bodies) {
  let grid = 0, numbers = 0;
  for (const body of bodies) {
    for (const range of body.ranges || []) for (const q of range.q) grid = (grid + q) % 4294967296;
    for (const v of body.mode === "mesh" ? [] : [...body.rest, ...(body.poses || [])]) numbers += v;
  }
  return { grid, numbers };
}

async function start() {
  const header = JSON.parse(byId("header").textContent);
  const texts = [...document.querySelectorAll("script.block")];
  const block = async (i) => inflate(texts[i].textContent);
  const bodies = [];
  for (const [number, entry] of header.bodies.entries()) bodies.push({ ...(await readBody(entry, block)), number });
  const fields = await readFields(header, block), contacts = await readContacts(header, block);
  for (const element of texts) element.remove();
  const times = header.times, begin = times[0], end = times[times.length - 1];
  for (const body of bodies) {
    const { low, high } = bodyBox({ ...body, mode: "fixed" }, 0);
    body.center = low.map((v, a) => 0.5 * (v + high[a]));
  }
  const bounds = sceneBounds(bodies, times.length, header.up);
  const renderer = new Renderer(byId("view"), bodies, bounds);
  const camera = new Camera(bounds);
  const wanted = new URLSearchParams(location.hash.slice(1));
  const options = { edges: false, flat: false, grid: true, shadows: true, contacts: false, loop: true };
  const state = { now: begin, playing: false, last: 0, waiting: false, moved: true };
  // A picture is drawn only when something changed; an idle page costs nothing.
  const redraw = () => {
    if (!state.waiting) requestAnimationFrame(tick);
    state.waiting = true;
  };
  const changed = () => {
    state.moved = true;
    redraw();
  };
  const selection = new Selection(bodies, contacts), marks = new Marks(byId("marks"), bounds);
  const select = (pin) => {
    selection.select(pin);
    bodyPanel.refresh();
  };
  const seek = (time) => {
    state.now = Math.min(end, Math.max(begin, time));
    state.moved = true;
    redraw();
  };
  const frameAt = (time) => {
    let k = times.findLastIndex((t) => t <= time + 1e-9);
    k = Math.max(0, Math.min(k, times.length - 1));
    return [k, k + 1 < times.length ? Math.min(1, Math.max(0, (time - times[k]) / (times[k + 1] - times[k] || 1))) : 0];
  };
  const draw = () => {
    const [k, f] = frameAt(state.now);
    if (state.moved) renderer.setFrame(k, f, fieldPanel.field);
    renderer.draw(camera, options);
    drawMarks(k, f);
    for (const chart of charts) chart.draw(state.now);
    scrub.value = state.now;
    byId("time").textContent = `${state.now.toFixed(2)} / ${end.toFixed(2)} s`;
    byId("clock").innerHTML = `<b>${state.now.toFixed(3)} s</b>frame ${k + 1} of ${times.length}`;
    state.moved = false;
  };
  const drawMarks = (k, f) => {
    const nearest = f < 0.5 ? k : Math.min(k + 1, times.length - 1), { pin } = selection;
    marks.begin(renderer.matrix);
    if (contacts && options.contacts) marks.contacts(contacts, nearest, bodies, renderer.clip, pin && pin.body);
    if (pin && pin.body.visible && pin.triangle !== undefined) marks.point(placeOf(pin));
    if (fieldPanel.field) marks.colorbar(fieldPanel.field, fieldPanel.points);
    if (pin) selection.describe(nearest, fieldPanel.field);
  };
  const tick = (clock) => {
    state.waiting = false;
    if (state.playing) {
      let next = state.now + (Number(byId("speed").value) * Math.min(250, clock - state.last)) / 1000;
      if (next >= end) {
        if (options.loop) next = begin + ((next - begin) % (end - begin || 1));
        else setPlaying(false);
      }
      seek(next);
    }
    state.last = clock;
    draw();
  };
  const setPlaying = (on) => {
    if (on && state.now >= end) seek(begin);
    state.playing = on && times.length > 1;
    byId("play").classList.toggle("on", state.playing);
    byId("play").setAttribute("aria-label", state.playing ? "Pause" : "Play");
    state.last = performance.now();
    redraw();
  };
  const setOption = (name, on) => {
    options[name] = on;
    byId(name).checked = on;
    redraw();
  };

  byId("meta").textContent = [
    `${bodies.length} ${bodies.length === 1 ? "body" : "bodies"}`,
    `${bodies.reduce((sum, b) => sum + b.triangles.length / 3, 0).toLocaleString("en")} triangles`,
    `${times.length} frames${header.stride > 1 ? ` (every ${header.stride}th)` : ""}`,
    header.stark_version ? `Stark ${header.stark_version}` : "", header.created.slice(0, 10),
  ].filter(Boolean).join("  ·  ");
  if (header.status !== "complete") {
    byId("badge").textContent = header.status;
    byId("badge").classList.toggle("failed", header.status === "failed");
    byId("badge").hidden = false;
  }
  const scrub = byId("scrub");
  const charts = makePlots(byId("plots"), header, seek);
  const fieldPanel = new FieldPanel(fields, header.colormaps, renderer, changed);
  const bodyPanel = new BodyPanel(bodies, changed, select);
  byId("contacts-option").hidden = !contacts;
  [scrub.min, scrub.max, scrub.value] = [begin, end, begin];
  scrub.addEventListener("input", () => seek(Number(scrub.value)));
  byId("play").addEventListener("click", () => setPlaying(!state.playing));
  for (const name of ["edges", "flat", "grid", "shadows", "contacts", "loop"])
    byId(name).addEventListener("change", (event) => setOption(name, event.target.checked));
  const toggle = (name) => setOption(name, !options[name]);
  const togglePanel = () => { document.body.classList.toggle("bare"); redraw(); };
  const toggleHelp = () => { byId("help").hidden = !byId("help").hidden; };
  byId("panel-button").addEventListener("click", togglePanel);
  byId("help-button").addEventListener("click", toggleHelp);
  byId("snapshot").addEventListener("click", () => {
    const link = document.createElement("a");
    link.download = `${header.scene || "stark"}_${state.now.toFixed(3)}s.png`;
    link.href = snapshot().toDataURL("image/png");
    link.click();
  });
  for (const id of ["clip-axis", "clip-at", "clip-flip"])
    byId(id).addEventListener("input", () => {
      renderer.clip = clipPlane(bounds);
      redraw();
    });
  const solo = () => {
    const own = selection.pin && selection.pin.body, alone = own && own.visible && bodies.every((b) => b === own || !b.visible);
    if (own) bodyPanel.showOnly((body) => alone || body === own);
  };
  byId("unselect").addEventListener("click", () => select(null));
  byId("solo").addEventListener("click", solo);
  byId("hide").addEventListener("click", () => bodyPanel.showOnly((body) => body.visible && body !== selection.pin.body));
  byId("opacity").addEventListener("input", (event) => {
    selection.pin.body.opacity = Number(event.target.value);
    redraw();
  });
  const reset = (view) => { camera.reset(view); redraw(); };
  const stepFrames = (count) => {
    setPlaying(false);
    const [k, f] = frameAt(state.now);
    seek(times[Math.min(times.length - 1, Math.max(0, k + count + (count < 0 && f > 1e-6 ? 1 : 0)))]);
  };
  addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.matches("select, input:not([type=range], [type=checkbox])")) return;
    const actions = {
      " ": () => setPlaying(!state.playing), ArrowLeft: () => stepFrames(event.shiftKey ? -10 : -1),
      ArrowRight: () => stepFrames(event.shiftKey ? 10 : 1), Home: () => seek(begin), End: () => seek(end),
      e: () => toggle("edges"), f: () => toggle("flat"), g: () => toggle("grid"), s: () => toggle("shadows"),
      c: () => contacts && toggle("contacts"), o: solo, Escape: () => select(null),
      l: () => toggle("loop"), r: () => reset(), p: togglePanel, h: toggleHelp,
      1: () => reset("oblique"), 2: () => reset("front"), 3: () => reset("side"), 4: () => reset("top"),
    };
    const action = actions[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (action) {
      event.preventDefault();
      action();
    }
  });
  listenToPointer(byId("view"), camera, redraw, reset, (x, y) => {
    const { clientWidth, clientHeight } = byId("view");
    select(pick(bodies, rayAt(camera, x, y, clientWidth, clientHeight), renderer.clip));
  });
  addEventListener("resize", redraw);

  if (wanted.has("t")) seek(Number(wanted.get("t")));
  if (wanted.has("view")) camera.reset(wanted.get("view"));
  if (wanted.has("field")) fieldPanel.show(wanted.get("field"));
  for (const name of ["edges", "flat", "grid", "shadows", "contacts"]) if (wanted.has(name)) setOption(name, wanted.get(name) === "1");
  if (wanted.get("bare") === "1") document.body.classList.add("bare");
  if (wanted.get("play") === "1") setPlaying(true);
  byId("message").hidden = true;

  redraw();
  document.body.dataset.state = "ready";
  if (wanted.has("selftest")) document.body.dataset.selftest = JSON.stringify(checksum(bodies));
}

// The picture with all that lies over it.
function snapshot() {
  const view = byId("view"), both = document.createElement("canvas");
  [both.width, both.height] = [view.width, view.height];
  for (const layer of [view, byId("marks")]) both.getContext("2d").drawImage(layer, 0, 0, view.width, view.height);
  return both;
}

// A press that does not move is a click: `choose` gets its place in the view.
function listenToPointer(view, camera, redraw, reset, choose) {
  const pointers = new Map();
  let spread = 0, moved = 0;
  view.addEventListener("pointerdown", (event) => {
    view.setPointerCapture(event.pointerId);
    view.classList.add("turning");
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
    spread = 0;
    moved = pointers.size > 1 || event.button !== 0 ? Infinity : 0;
  });
  view.addEventListener("pointerup", (event) => {
    const area = view.getBoundingClientRect();
    if (moved < 5) choose(event.clientX - area.left, event.clientY - area.top);
  });
  const release = (event) => {
    pointers.delete(event.pointerId);
    spread = 0;
    if (!pointers.size) view.classList.remove("turning");
  };
  view.addEventListener("pointerup", release);
  view.addEventListener("pointercancel", release);
  view.addEventListener("pointermove", (event) => {
    const before = pointers.get(event.pointerId);
    if (!before) return;
    const dx = event.clientX - before[0], dy = event.clientY - before[1];
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
    moved += Math.abs(dx) + Math.abs(dy);
    if (moved < 5) return;
    if (pointers.size === 2) {
      const [a, b] = [...pointers.values()], now = Math.hypot(a[0] - b[0], a[1] - b[1]);
      if (spread) camera.zoom(spread / now);
      spread = now;
      camera.move(dx / 2, dy / 2, view.clientHeight);
    } else if (event.buttons & 6 || event.shiftKey) camera.move(dx, dy, view.clientHeight);
    else camera.turn(dx, dy);
    redraw();
  });
  view.addEventListener("wheel", (event) => {
    event.preventDefault();
    camera.zoom(Math.exp(0.0012 * event.deltaY * (event.deltaMode === 1 ? 20 : 1)));
    redraw();
  }, { passive: false });
  view.addEventListener("contextmenu", (event) => event.preventDefault());
  view.addEventListener("dblclick", () => reset());
}

start().catch((error) => {
  const message = byId("message");
  message.hidden = false;
  message.textContent = "The recording cannot be shown: " + error.message;
  document.body.dataset.state = "error";
});
