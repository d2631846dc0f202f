// Sections of closed bodies in the clip plane, so that what is cut looks solid. A ray from the eye meets a section where it
// leaves more faces of the kept part than it enters; the stencil buffer counts them, and the plane is drawn where it is not 0.
// [McReynolds and Blythe 2005, "Advanced graphics programming using OpenGL", capping clipped solids with the stencil buffer]

// Whether triangles bound a volume: each edge has as many triangles in one direction as in the other. Vertices at the same place are one.
function isClosed(triangles, positions) {
  const places = new Map(), first = new Uint32Array(positions.length / 3), edges = new Map();
  for (let i = 0; i < first.length; ++i) {
    const key = `${positions[3 * i]},${positions[3 * i + 1]},${positions[3 * i + 2]}`;
    if (!places.has(key)) places.set(key, i);
    first[i] = places.get(key);
  }
  for (let t = 0; t < triangles.length; t += 3)
    for (let e = 0; e < 3; ++e) {
      const a = first[triangles[t + e]], b = first[triangles[t + ((e + 1) % 3)]];
      const key = Math.min(a, b) * first.length + Math.max(a, b), sum = (edges.get(key) || 0) + Math.sign(b - a);
      if (sum) edges.set(key, sum);
      else edges.delete(key);
    }
  return triangles.length > 0 && edges.size === 0;
}

// Sheets and what lies around the scene are never filled. The answer is kept; it costs milliseconds for large meshes.
function isSolid(body) {
  if (body.closed === undefined) body.closed = !body.isSheet && isClosed(body.triangles, body.rest);
  return body.closed && !body.scenery;
}

// Extent of a body along a direction in the world: [lowest, highest].
function extentAlong(body, normal) {
  const p = body.positions, m = body.model, n = [0, 1, 2].map((a) => dot3(normal, [m[4 * a], m[4 * a + 1], m[4 * a + 2]]));
  let low = Infinity, high = -Infinity;
  for (let i = 0; i < p.length; i += 3) {
    const s = n[0] * p[i] + n[1] * p[i + 1] + n[2] * p[i + 2];
    if (s < low) low = s;
    if (s > high) high = s;
  }
  const shift = dot3(normal, [m[12], m[13], m[14]]);
  return [low + shift, high + shift];
}

class Caps {
  constructor(renderer) {
    const gl = renderer.gl;
    this.renderer = renderer;
    this.array = gl.createVertexArray();
    this.buffer = gl.createBuffer();
    gl.bindVertexArray(this.array);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffer);
    for (const [place, offset] of [[0, 0], [1, 12]]) {
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, 3, gl.FLOAT, false, 24, offset);
    }
    gl.bindVertexArray(null);
  }

  // The sections of all bodies that the plane crosses, those of small ones first: what lies in a closed case stays in sight.
  draw(matrix) {
    const { gl, bodies, clip } = this.renderer, normal = clip.slice(0, 3);
    if (!normal.some((c) => c)) return;
    const crossed = [];
    for (const body of bodies) {
      if (!body.visible || body.opacity === 0 || !isSolid(body)) continue;
      const [low, high] = extentAlong(body, normal);
      if (low < clip[3] && clip[3] < high) crossed.push({ body, size: high - low });
    }
    if (!crossed.length) return;
    this.placeQuad(normal, clip[3]);
    gl.enable(gl.STENCIL_TEST);
    for (const { body } of crossed.sort((a, b) => a.size - b.size)) {
      this.count(matrix, body);
      this.fill(body);
    }
    gl.disable(gl.STENCIL_TEST);
  }

  // Faces of the kept part towards the eye count -1, those away from it +1, whatever lies before them.
  count(matrix, body) {
    const { gl, depth } = this.renderer;
    gl.clear(gl.STENCIL_BUFFER_BIT);
    gl.disable(gl.DEPTH_TEST);
    gl.colorMask(false, false, false, false);
    gl.stencilFunc(gl.ALWAYS, 0, 0xff);
    gl.stencilOpSeparate(gl.FRONT, gl.KEEP, gl.KEEP, gl.DECR_WRAP);
    gl.stencilOpSeparate(gl.BACK, gl.KEEP, gl.KEEP, gl.INCR_WRAP);
    gl.useProgram(depth.program);
    this.renderer.drawBodies(depth, matrix, false, (other) => other === body);
    gl.colorMask(true, true, true, true);
    gl.enable(gl.DEPTH_TEST);
  }

  fill(body) {
    const { gl, surface, field } = this.renderer;
    gl.useProgram(surface.program);
    gl.stencilFunc(gl.NOTEQUAL, 0, 0xff);
    gl.stencilOp(gl.KEEP, gl.KEEP, gl.KEEP);
    gl.uniformMatrix4fv(surface.model, false, IDENTITY);
    gl.uniform4f(surface.horizon, 0, 0, 0, 0);
    gl.uniform4f(surface.clip, 0, 0, 0, 1); // the section lies in the plane, which rounding must not cut
    gl.uniform3fv(surface.color, field ? NEUTRAL : body.color); // values inside are not in the recording
    for (const [name, value] of [["hasField", 0], ["opacity", body.opacity], ["marked", 0], ["backTint", 0]]) gl.uniform1f(surface[name], value);
    gl.bindVertexArray(this.array);
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    gl.bindVertexArray(null);
  }

  // A part of the plane that covers the scene.
  placeQuad(normal, offset) {
    const { gl, bounds } = this.renderer, middle = bounds.center, reach = 50 * bounds.radius;
    const u = normalize3(cross3(normal, Math.abs(normal[2]) < 0.5 ? [0, 0, 1] : [1, 0, 0])), v = cross3(normal, u);
    const lift = offset - dot3(normal, middle), data = [];
    for (const [i, j] of [[-1, -1], [1, -1], [-1, 1], [1, 1]])
      data.push(...middle.map((c, a) => c + lift * normal[a] + reach * (i * u[a] + j * v[a])), ...normal);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffer);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(data), gl.DYNAMIC_DRAW);
  }
}
