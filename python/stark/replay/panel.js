// The side panel: fields, the selected body, the list of bodies with its filter, the clip plane.

function hexColor(color) {
  return "#" + color.map((c) => Math.round(255 * c).toString(16).padStart(2, "0")).join("");
}

function element(tag, className, text, parent) {
  const made = document.createElement(tag);
  if (className) made.className = className;
  if (text) made.textContent = text;
  if (parent) parent.append(made);
  return made;
}

// A field by colours: what is shown, of which colours, between which limits.
class FieldPanel {
  constructor(fields, colormaps, renderer, changed) {
    [this.fields, this.colormaps, this.renderer, this.changed] = [fields, colormaps, renderer, changed];
    this.field = null;
    const choice = (this.choice = byId("field")), map = (this.map = byId("colormap"));
    for (const field of fields) choice.add(new Option(field.label, field.name));
    for (const name of Object.keys(colormaps)) map.add(new Option(name, name));
    choice.addEventListener("change", () => this.show(choice.value));
    map.addEventListener("change", () => this.show(choice.value));
    for (const id of ["low", "high"]) byId(id).addEventListener("change", () => this.limit());
    byId("limits-reset").addEventListener("click", () => {
      this.field.limits = [...this.field.given];
      this.show(choice.value);
    });
    byId("fields").hidden = !fields.length;
    this.show("");
  }
  get points() {
    return this.colormaps[this.map.value] || Object.values(this.colormaps)[0];
  }
  show(name) {
    this.field = this.fields.find((field) => field.name === name) || null;
    this.choice.value = this.field ? name : "";
    byId("field-options").hidden = !this.field;
    if (this.field) {
      this.renderer.setColormap(this.points);
      [byId("low").value, byId("high").value] = this.field.limits.map((v) => Number(v.toPrecision(4)));
      byId("field-unit").textContent = this.field.unit;
    }
    this.changed();
  }
  limit() {
    const [low, high] = ["low", "high"].map((id) => Number(byId(id).value));
    if (low < high) this.field.limits = [low, high];
    this.show(this.choice.value);
  }
}

// Names without the number at their end make groups: "brick_1", "brick_2" are of "brick".
function groupOf(name) {
  return name.includes("/") ? name.slice(0, name.lastIndexOf("/")) : name.replace(/[\s_.-]*\d+$/, "") || name;
}

const GROUPED_FROM = 9; // bodies; fewer are listed one by one

// The list of bodies, and which of them are seen.
class BodyPanel {
  constructor(bodies, changed, select) {
    [this.bodies, this.changed, this.select] = [bodies, changed, select];
    this.rows = new Map();
    const list = byId("bodies"), groups = new Map();
    for (const body of bodies) groups.set(groupOf(body.name), [...(groups.get(groupOf(body.name)) || []), body]);
    const grouped = bodies.length >= GROUPED_FROM;
    for (const [name, members] of groups) {
      const parent = grouped && members.length > 1 ? this.group(name, members, list) : list;
      for (const body of members) parent.append(this.row(body));
    }
    const filter = byId("filter");
    filter.addEventListener("input", () => this.filter());
    byId("show-all").addEventListener("click", () => this.showOnly(() => true));
    byId("only-these").addEventListener("click", () => this.showOnly((body) => this.matches(body)));
    byId("hide-these").addEventListener("click", () => this.showOnly((body) => body.visible && !this.matches(body)));
    byId("filters").hidden = bodies.length < 2;
    this.filter();
  }
  // All words of the filter are in the name or kind of the body.
  matches(body) {
    const text = `${body.name} ${body.kind} ${body.motion}`.toLowerCase();
    return byId("filter").value.toLowerCase().split(/\s+/).every((word) => text.includes(word.replaceAll("*", "")));
  }
  filter() {
    for (const [body, { row }] of this.rows) row.hidden = !this.matches(body);
    for (const group of byId("bodies").querySelectorAll("details"))
      group.hidden = ![...group.querySelectorAll(".body")].some((row) => !row.hidden);
    byId("only-these").disabled = byId("hide-these").disabled = !byId("filter").value.trim();
  }
  showOnly(wanted) {
    for (const body of this.bodies) body.visible = wanted(body);
    this.refresh();
  }
  refresh() {
    for (const [body, { row, box }] of this.rows) {
      box.checked = body.visible;
      row.classList.toggle("off", !body.visible);
      row.classList.toggle("marked", body.marked);
    }
    for (const group of byId("bodies").querySelectorAll("details")) {
      const boxes = [...group.querySelectorAll(".body input[type=checkbox]")], own = group.querySelector("summary input");
      own.checked = boxes.every((box) => box.checked);
      own.indeterminate = !own.checked && boxes.some((box) => box.checked);
    }
    this.changed();
  }
  group(name, members, list) {
    const group = element("details", "group", "", list), summary = element("summary", "", "", group);
    element("span", "name", name, summary);
    element("span", "kind", `${members.length}`, summary);
    const box = element("input", "", "", summary);
    box.type = "checkbox";
    box.checked = true;
    box.title = `Show all of ${name}`;
    box.addEventListener("change", () => {
      for (const body of members) body.visible = box.checked;
      this.refresh();
    });
    return group;
  }
  row(body) {
    const row = element("div", "body"), swatch = element("input", "", "", row);
    swatch.type = "color";
    swatch.value = hexColor(body.color);
    swatch.title = "Colour of " + body.name;
    swatch.addEventListener("input", () => {
      body.color = [1, 3, 5].map((i) => parseInt(swatch.value.slice(i, i + 2), 16) / 255);
      this.changed();
    });
    const name = element("span", "name", body.name, row);
    name.title = "Select " + body.name;
    name.addEventListener("click", () => this.select({ body }));
    element("span", "kind", body.motion !== "dynamic" ? body.motion : body.kind, row);
    const box = element("input", "", "", row);
    box.type = "checkbox";
    box.checked = true;
    box.title = "Show " + body.name;
    box.addEventListener("change", () => {
      body.visible = box.checked;
      this.refresh();
    });
    this.rows.set(body, { row, box });
    return row;
  }
}

// The selected body: where the picked point is, the contact force on the body, the value there, its opacity.
class Selection {
  constructor(bodies, contacts) {
    [this.bodies, this.contacts, this.pin] = [bodies, contacts, null];
  }
  select(pin) {
    this.pin = pin;
    for (const body of this.bodies) body.marked = pin !== null && body === pin.body;
    byId("selection").hidden = pin === null;
    if (pin) byId("opacity").value = pin.body.opacity;
  }
  // Sum of the contact forces on the body in frame k [N], null where it is not recorded.
  force(k) {
    const { contacts } = this, i = this.pin.body.number;
    if (!contacts || i >= contacts.bodies) return null;
    return [0, 1, 2].map((a) => contacts.sums[3 * (k * contacts.bodies + i) + a]);
  }
  describe(k, field) {
    const { body, triangle } = this.pin;
    // Components that are nothing beside the largest one are 0.
    const vector = (v) => v.map((c) => shortNumber(Math.abs(c) < 5e-4 * Math.hypot(...v) ? 0 : c)).join(", ");
    const lines = [[triangle === undefined ? "Middle [m]" : "Position [m]", vector(placeOf(this.pin))]];
    const force = this.force(k), value = valueAt(this.pin);
    if (force) lines.push(["Contact force", forceText(Math.hypot(...force))], ["Along x, y, z [N]", vector(force)]);
    if (value !== null) {
      const [[text], unit] = withPrefix([value], field.unit);
      lines.push([field.label, `${text} ${unit}`]);
    }
    byId("selected-name").textContent = body.name;
    byId("selected-kind").textContent = [body.kind, body.motion].join(", ");
    byId("selected-facts").replaceChildren(
      ...lines.flatMap(([term, text]) => [element("dt", "", term), element("dd", "", text)]),
    );
  }
}

// A plane across an axis that takes away what lies beyond it: normal and offset, {x: n.x <= offset} stays.
function clipPlane(bounds) {
  const axis = { x: 0, y: 1, z: 2 }[byId("clip-axis").value], share = Number(byId("clip-at").value);
  byId("clip-options").hidden = axis === undefined;
  if (axis === undefined) return [0, 0, 0, 1];
  const at = bounds.low[axis] + share * (bounds.high[axis] - bounds.low[axis]), sign = byId("clip-flip").checked ? -1 : 1;
  byId("clip-place").textContent = `${shortNumber(at)} m`;
  const plane = [0, 0, 0, sign * at];
  plane[axis] = sign;
  return plane;
}
