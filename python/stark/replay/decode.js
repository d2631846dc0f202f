// Reads the embedded recording: base64 -> raw deflate -> positions. encode.py describes the format and is its inverse.

async function inflate(text) {
  const raw = atob(text.trim());
  const bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; ++i) bytes[i] = raw.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// Grid coordinates of one range, [frame][vertex][axis]; Uint16Array keeps every sum modulo 65536.
function decodeRange(bytes, frameCount, vertexCount) {
  const n = 3 * vertexCount, total = n * frameCount;
  const q = new Uint16Array(total);
  for (let i = 0; i < total; ++i) q[i] = bytes[i] | (bytes[total + i] << 8);
  for (let i = 3; i < n; ++i) q[i] += q[i - 3];
  for (let k = 1; k < frameCount; ++k) {
    const now = k * n, before = now - n, first = before - n;
    if (k === 1) for (let i = 0; i < n; ++i) q[now + i] += q[before + i];
    else for (let i = 0; i < n; ++i) q[now + i] += 2 * q[before + i] - q[first + i];
  }
  return q;
}

async function readBody(entry, block) {
  const triangles = new Uint32Array((await block(entry.index)).buffer);
  // Sheets, the one kind that pages tell apart: smooth, paler on the back, never filled.
  const body = { ...entry, isSheet: entry.kind === "cloth", visible: true, opacity: 1, marked: false, triangles };
  if (entry.mode === "mesh") {
    body.ranges = [];
    for (const range of entry.ranges) {
      body.ranges.push({ ...range, q: decodeRange(await block(range.block), range.count, entry.vertices) });
    }
    body.rest = new Float32Array(3 * entry.vertices);
    positionsAt(body, 0, body.rest);
  } else {
    body.rest = new Float32Array((await block(entry.rest)).buffer);
    if (entry.mode === "rigid") body.poses = new Float32Array((await block(entry.poses)).buffer);
  }
  return body;
}

// Positions of a "mesh" body at frame k (an integer) into out.
function positionsAt(body, k, out) {
  const range = body.ranges.find((r) => k >= r.start && k < r.start + r.count);
  const n = 3 * body.vertices, offset = (k - range.start) * n, [x, y, z] = range.low, h = range.step;
  for (let i = 0; i < n; i += 3) {
    out[i] = x + h * range.q[offset + i];
    out[i + 1] = y + h * range.q[offset + i + 1];
    out[i + 2] = z + h * range.q[offset + i + 2];
  }
}

// Positions between frames k and k + 1, f in [0, 1).
function positionsBetween(body, k, f, out, scratch) {
  positionsAt(body, k, out);
  if (f <= 0) return;
  positionsAt(body, k + 1, scratch);
  for (let i = 0; i < out.length; ++i) out[i] += f * (scratch[i] - out[i]);
}

// Column-major 4x4 matrix of a "rigid" body between frames k and k + 1: linear in the translation of the body's
// first-frame centre, normalised-linear in the rotation, so that a fast spinning body does not shrink.
function poseBetween(body, k, f) {
  const a = body.poses.subarray(7 * k, 7 * k + 7);
  const b = f > 0 ? body.poses.subarray(7 * k + 7, 7 * k + 14) : a;
  const q = [0, 1, 2, 3].map((i) => a[i] + f * (b[i] - a[i]));
  const m = rotation(q), c = body.center;
  const at = (pose) => {
    const r = rotation(pose);
    return [0, 1, 2].map((i) => r[i] * c[0] + r[3 + i] * c[1] + r[6 + i] * c[2] + pose[4 + i]);
  };
  const p = at(a), e = at(b);
  const t = [0, 1, 2].map((i) => p[i] + f * (e[i] - p[i]) - (m[i] * c[0] + m[3 + i] * c[1] + m[6 + i] * c[2]));
  return new Float32Array([m[0], m[1], m[2], 0, m[3], m[4], m[5], 0, m[6], m[7], m[8], 0, t[0], t[1], t[2], 1]);
}

// Column-major 3x3 rotation of a quaternion w, x, y, z of any length.
function rotation(q) {
  const s = 1 / Math.hypot(q[0], q[1], q[2], q[3]);
  const w = q[0] * s, x = q[1] * s, y = q[2] * s, z = q[3] * s;
  return [
    1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y),
    2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x),
    2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y),
  ];
}

// Splits vertices along sharp edges: corners of triangles that meet at a smooth edge share a render vertex.
// Returns the corner -> render vertex index, the source vertex of each render vertex, and the unique mesh edges.
function renderMesh(triangles, positions, creaseCosine) {
  const count = triangles.length / 3, normals = new Float32Array(3 * count);
  for (let t = 0; t < count; ++t) {
    const [a, b, c] = [0, 1, 2].map((i) => 3 * triangles[3 * t + i]);
    const ux = positions[b] - positions[a], uy = positions[b + 1] - positions[a + 1], uz = positions[b + 2] - positions[a + 2];
    const vx = positions[c] - positions[a], vy = positions[c + 1] - positions[a + 1], vz = positions[c + 2] - positions[a + 2];
    const nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
    const s = 1 / (Math.hypot(nx, ny, nz) || 1);
    normals.set([nx * s, ny * s, nz * s], 3 * t);
  }
  const parent = new Int32Array(3 * count).map((_, i) => i);
  const find = (i) => {
    while (parent[i] !== i) i = parent[i] = parent[parent[i]];
    return i;
  };
  const edges = new Map(), stride = positions.length / 3 + 1, lines = [];
  for (let t = 0; t < count; ++t) {
    for (let e = 0; e < 3; ++e) {
      const i = 3 * t + e, j = 3 * t + (e + 1) % 3;
      const u = triangles[i], v = triangles[j], key = Math.min(u, v) * stride + Math.max(u, v);
      const other = edges.get(key);
      if (other === undefined) {
        edges.set(key, [i, j, t]);
        lines.push(i, j);
        continue;
      }
      const [oi, oj, s] = other;
      const cosine = normals[3 * t] * normals[3 * s] + normals[3 * t + 1] * normals[3 * s + 1] + normals[3 * t + 2] * normals[3 * s + 2];
      if (cosine < creaseCosine) continue;
      const same = triangles[oi] === u;
      parent[find(i)] = find(same ? oi : oj);
      parent[find(j)] = find(same ? oj : oi);
    }
  }
  const index = new Uint32Array(3 * count), source = [], seen = new Map();
  for (let i = 0; i < index.length; ++i) {
    const root = find(i);
    if (!seen.has(root)) {
      seen.set(root, source.length);
      source.push(triangles[i]);
    }
    index[i] = seen.get(root);
  }
  return { index, source: new Uint32Array(source), lines: new Uint32Array(lines.map((corner) => index[corner])) };
}

// Fields of the header with their numbers: values of body i at frame k are low + step * q[i][k * vertices + vertex].
async function readFields(header, block) {
  const fields = [];
  for (const entry of header.fields || []) {
    const q = {};
    for (const [i, number] of Object.entries(entry.blocks)) {
      const bytes = await block(number), n = header.bodies[i].vertices, total = bytes.length / 2;
      q[i] = new Uint16Array(total);
      for (let k = 0; k < total; ++k) q[i][k] = (bytes[k] | (bytes[total + k] << 8)) + (k >= n ? q[i][k - n] : 0);
    }
    fields.push({ ...entry, q, limits: [...entry.limits], given: [...entry.limits] });
  }
  return fields;
}

// Values of a field at the vertices of a body between frames k and k + 1, null where it has none.
function valuesBetween(field, body, k, f) {
  const q = field.q[body.number], n = body.vertices;
  if (!q) return null;
  const out = new Float32Array(n), now = k * n, next = f > 0 ? now + n : now;
  for (let i = 0; i < n; ++i) out[i] = field.low + field.step * (q[now + i] + f * (q[next + i] - q[now + i]));
  return out;
}

// Contacts by frame, or null where none were recorded.
async function readContacts(header, block) {
  const given = header.contacts;
  if (!given) return null;
  const floats = async (number) => new Float32Array((await block(number)).buffer);
  const starts = [0];
  for (const count of given.counts) starts.push(starts[starts.length - 1] + count);
  return {
    ...given, starts, points: await floats(given.points), forces: await floats(given.forces),
    sums: await floats(given.sums), pairs: new Uint16Array((await block(given.pairs)).buffer),
  };
}

// Colour at a share in [0, 1] of evenly spaced colours.
function colorAt(points, share) {
  const at = share * (points.length - 1), i = Math.min(points.length - 2, Math.floor(at));
  return points[i].map((c, a) => c + (at - i) * (points[i + 1][a] - c));
}
