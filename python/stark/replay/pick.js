// Which point of which body lies under a pixel: the ray through it against all triangles that are seen.

// Ray (origin, direction) through a pixel of a view of width x height.
function rayAt(camera, x, y, width, height) {
  const back = camera.direction(), right = normalize3(cross3(camera.up(), back)), top = cross3(back, right);
  const half = Math.tan(camera.fov / 2), sx = ((2 * x) / width - 1) * half * (width / height), sy = (1 - (2 * y) / height) * half;
  return { origin: camera.eye(), direction: normalize3(back.map((b, a) => sx * right[a] + sy * top[a] - b)) };
}

// The same ray in the frame in which the vertices of a body are given; a rigid motion keeps lengths along it.
function localRay(body, { origin, direction }) {
  if (body.mode !== "rigid") return { origin, direction };
  const m = body.model, arm = origin.map((c, a) => c - m[12 + a]);
  const turned = (v) => [0, 1, 2].map((a) => m[4 * a] * v[0] + m[4 * a + 1] * v[1] + m[4 * a + 2] * v[2]);
  return { origin: turned(arm), direction: turned(direction) };
}

function inWorld(body, p) {
  const m = body.model;
  return [0, 1, 2].map((a) => m[a] * p[0] + m[4 + a] * p[1] + m[8 + a] * p[2] + m[12 + a]);
}

// Nearest hit of a ray with a body: distance, triangle and weights of its corners; null if there is none before `nearest`.
// A hit of its section by the clip plane has no triangle: it is hit where the ray leaves the body more often than it enters.
// [Moeller and Trumbore 1997, "Fast, minimum storage ray-triangle intersection"]
function hitBody(body, ray, clip, nearest) {
  const { origin: o, direction: d } = localRay(body, ray), p = body.positions, index = body.triangles;
  let best = null, left = 0;
  for (let t = 0; t < index.length; t += 3) {
    const a = 3 * index[t], b = 3 * index[t + 1], c = 3 * index[t + 2];
    const ux = p[b] - p[a], uy = p[b + 1] - p[a + 1], uz = p[b + 2] - p[a + 2];
    const vx = p[c] - p[a], vy = p[c + 1] - p[a + 1], vz = p[c + 2] - p[a + 2];
    const hx = d[1] * vz - d[2] * vy, hy = d[2] * vx - d[0] * vz, hz = d[0] * vy - d[1] * vx;
    const det = ux * hx + uy * hy + uz * hz;
    if (det === 0) continue;
    const sx = o[0] - p[a], sy = o[1] - p[a + 1], sz = o[2] - p[a + 2];
    const u = (sx * hx + sy * hy + sz * hz) / det;
    if (!(u >= 0 && u <= 1)) continue;
    const qx = sy * uz - sz * uy, qy = sz * ux - sx * uz, qz = sx * uy - sy * ux;
    const v = (d[0] * qx + d[1] * qy + d[2] * qz) / det, s = (vx * qx + vy * qy + vz * qz) / det;
    if (!(v >= 0 && u + v <= 1) || s <= 0) continue;
    const place = ray.origin.map((c0, i) => c0 + s * ray.direction[i]);
    if (!body.scenery && dot3(clip, place) > clip[3]) continue;
    left += Math.sign(det);
    if (s >= nearest) continue;
    nearest = s;
    best = { body, distance: s, triangle: t, weights: [1 - u - v, u, v] };
  }
  const steep = dot3(clip, ray.direction), s = steep ? (clip[3] - dot3(clip, ray.origin)) / steep : 0;
  return left && s > 0 && s < nearest && isSolid(body) ? { body, distance: s } : best;
}

function pick(bodies, ray, clip) {
  let best = null;
  for (const body of bodies) {
    if (!body.visible || body.opacity === 0) continue;
    best = hitBody(body, ray, clip, best ? best.distance : Infinity) || best;
  }
  return best;
}

// Where the picked point of a body is now; it moves with the body. Without a triangle, the middle of the body.
function placeOf(pin) {
  const { body, triangle, weights } = pin, p = body.positions;
  if (triangle === undefined) {
    const sum = [0, 0, 0], n = p.length / 3 || 1;
    for (let i = 0; i < p.length; ++i) sum[i % 3] += p[i] / n;
    return inWorld(body, sum);
  }
  return inWorld(body, [0, 1, 2].map((a) => weights.reduce((s, w, k) => s + w * p[3 * body.triangles[triangle + k] + a], 0)));
}

// Value of the field on show at a picked point, null without one.
function valueAt({ body, triangle, weights }) {
  if (!body.values || triangle === undefined) return null;
  return weights.reduce((s, w, k) => s + w * body.values[body.triangles[triangle + k]], 0);
}
