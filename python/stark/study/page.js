"use strict";
// The page of a study: plots of all runs, and a table that can be sorted. Names and messages are set as text only.
const data = JSON.parse(document.getElementById("data").textContent);
const SVG = "http://www.w3.org/2000/svg", WIDTH = 420, HEIGHT = 220, LEFT = 56, BOTTOM = 28, TOP = 8, RIGHT = 8;
const at = (id) => document.getElementById(id);

function element(name, attributes = {}, text = null, space = null) {
  const made = space ? document.createElementNS(space, name) : document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (text !== null) made.textContent = text;
  return made;
}

function shown(value) {
  if (value === null || value === undefined) return "";
  if (typeof value !== "number") return String(value);
  return Number.isInteger(value) ? String(value) : (Math.abs(value) < 1e-3 ? value.toExponential(2) : String(Number(value.toPrecision(5))));
}

const column = (name) => data.columns.indexOf(name);
const isNumber = (name) => data.rows.some((row) => typeof row[column(name)] === "number");

// Colours of the runs by the rank of their value in a column: blue to yellow for numbers, a wheel for texts.
function colors(name) {
  const values = data.rows.map((row) => row[column(name)]);
  const numeric = values.every((v) => typeof v === "number");
  const kinds = [...new Set(values)].sort(numeric ? (a, b) => a - b : undefined);
  const rank = new Map(kinds.map((v, k) => [v, k]));
  return values.map((v) => numeric
    ? `hsl(${250 - 210 * rank.get(v) / Math.max(1, kinds.length - 1)} 70% 57%)`
    : `hsl(${360 * rank.get(v) / kinds.length} 65% 52%)`);
}

function ticks(low, high) {
  const raw = (high - low) / 4 || 1, power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= raw);
  const found = [];
  for (let t = Math.ceil(low / step) * step; t <= high + 1e-9 * step; t += step) found.push(Number(t.toPrecision(12)));
  return found;
}

// A figure with axes; `lines` are {run, x, y}. A line of one point is a dot.
function figure(title, across, lines, paint) {
  const xs = lines.flatMap((l) => l.x), ys = lines.flatMap((l) => l.y).filter((y) => y !== null);
  const span = (v) => v.reduce(([a, b], x) => [Math.min(a, x), Math.max(b, x)], [Infinity, -Infinity]);
  let [x0, x1] = span(xs), [y0, y1] = span(ys);
  if (!(y1 > y0)) { const pad = Math.abs(y0) * 0.1 || 1; y0 -= pad; y1 += pad; }
  if (!(x1 > x0)) { x0 -= 0.5; x1 += 0.5; }
  const X = (x) => LEFT + (x - x0) / (x1 - x0) * (WIDTH - LEFT - RIGHT);
  const Y = (y) => HEIGHT - BOTTOM - (y - y0) / (y1 - y0) * (HEIGHT - BOTTOM - TOP);
  const made = element("figure"), svg = element("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT + 14}`, role: "img" }, null, SVG);
  svg.append(element("title", {}, title, SVG));
  const add = (name, attributes, text = null) => svg.append(element(name, attributes, text, SVG));
  for (const t of ticks(y0, y1)) {
    add("path", { class: "axis", d: `M${LEFT} ${Y(t)}H${WIDTH - RIGHT}` });
    add("text", { x: LEFT - 4, y: Y(t) + 4, "text-anchor": "end" }, shown(t));
  }
  for (const t of ticks(x0, x1)) add("text", { x: X(t), y: HEIGHT - BOTTOM + 15, "text-anchor": "middle" }, shown(t));
  add("text", { x: WIDTH - RIGHT, y: HEIGHT + 8, "text-anchor": "end" }, across);
  for (const { run, x, y } of lines) {
    const points = x.map((v, k) => [v, y[k]]).filter(([, v]) => v !== null);
    if (!points.length) continue;
    const mark = points.length === 1
      ? element("circle", { class: "dot", cx: X(points[0][0]), cy: Y(points[0][1]), r: 4, fill: paint[run] }, null, SVG)
      : element("path", { class: "run", stroke: paint[run], d: "M" + points.map(([a, b]) => `${X(a).toFixed(1)} ${Y(b).toFixed(1)}`).join("L") }, null, SVG);
    mark.dataset.run = run;
    mark.append(element("title", {}, data.labels[run], SVG));
    svg.append(mark);
  }
  made.append(element("figcaption", {}, title), svg);
  return made;
}

function legend(name, paint) {
  const k = column(name), first = new Map();
  data.rows.forEach((row, run) => { if (!first.has(row[k])) first.set(row[k], paint[run]); });
  const entries = [...first].sort(([a], [b]) => (typeof a === "number" ? a - b : 0));
  const few = entries.length <= 8 ? entries : [entries[0], entries[entries.length >> 1], entries.at(-1)];
  at("legend").replaceChildren(...few.map(([value, color]) => {
    const item = element("span"), swatch = element("i");
    swatch.style.background = color;
    item.append(swatch, shown(value));
    return item;
  }));
}

function draw() {
  const paint = colors(at("color").value), across = at("across").value, up = at("up").value;
  const figures = [];
  legend(at("color").value, paint);
  if (across && up) {
    const lines = data.rows.map((row, run) => ({ run, x: [row[column(across)]], y: [row[column(up)]] }))
      .filter((l) => typeof l.x[0] === "number" && typeof l.y[0] === "number");
    if (lines.length) figures.push(figure(`${up} against ${across}`, across, lines, paint));
  }
  for (const plot of data.plots) figures.push(figure(plot.title, "time [s]", plot.lines, paint));
  at("plots").replaceChildren(...figures);
}

function cell(name, value, run) {
  const made = element("td", { class: name === "status" ? "status text" : typeof value === "string" ? "text" : "" }, shown(value));
  if (typeof value === "string") made.title = value;
  if (name === "run" && data.replays[run]) made.replaceChildren(element("a", { href: data.replays[run] }, shown(value)));
  return made;
}

function rows(order) {
  return order.map((run) => {
    const row = element("tr", data.rows[run][column("status")] === "complete" ? {} : { class: "bad" });
    row.dataset.run = run;
    const picture = element("td");
    if (data.thumbnails[run]) {
      const image = element("img", { src: data.thumbnails[run], alt: data.labels[run], loading: "lazy" });
      const link = data.replays[run] ? element("a", { href: data.replays[run] }) : element("span");
      link.append(image);
      picture.append(link);
    }
    row.append(picture, ...data.columns.map((name, k) => cell(name, data.rows[run][k], run)));
    return row;
  });
}

function sort(head, k) {
  const rising = head.getAttribute("aria-sort") !== "ascending";
  for (const other of document.querySelectorAll("th")) other.removeAttribute("aria-sort");
  head.setAttribute("aria-sort", rising ? "ascending" : "descending");
  const order = data.rows.map((_, run) => run), sign = rising ? 1 : -1;
  order.sort((a, b) => {
    const [x, y] = [data.rows[a][k], data.rows[b][k]];
    if (x === null || y === null) return (x === null) - (y === null);  // what is missing comes last
    const both = typeof x === "number" && typeof y === "number";
    return sign * (both ? x - y : String(x).localeCompare(String(y))) || a - b;
  });
  document.querySelector("tbody").replaceChildren(...rows(order));
}

function mark(event) {
  const run = event.target.closest?.("[data-run]")?.dataset.run;
  for (const other of document.querySelectorAll(".marked")) other.classList.remove("marked");
  if (run !== undefined) for (const same of document.querySelectorAll(`[data-run="${run}"]`)) same.classList.add("marked");
}

function choose(id, names, first) {
  at(id).replaceChildren(...names.map((name) => element("option", { value: name }, name)));
  if (names.includes(first)) at(id).value = first;
  at(id).addEventListener("change", draw);
}

at("summary").textContent = data.summary;
at("limits").textContent = data.limits;
const head = element("tr");
head.append(element("th"));
data.columns.forEach((name, k) => {
  const made = element("th", { scope: "col" }), button = element("button", {}, name);
  button.addEventListener("click", () => sort(made, k));
  made.append(button);
  head.append(made);
});
document.querySelector("thead").append(head);
document.querySelector("tbody").append(...rows(data.rows.map((_, run) => run)));
const options = data.columns.filter((name) => name.startsWith("option."));
const results = data.columns.filter((name) => isNumber(name) && !name.startsWith("option.") && name !== "run");
choose("color", options.length ? options : ["run"], options[1] ?? options[0]);
choose("across", options.filter(isNumber), options.filter(isNumber)[0]);
choose("up", results, results.find((name) => name.startsWith("observables.")) ?? results[0]);
document.addEventListener("mouseover", mark);
draw();
