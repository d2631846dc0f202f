// The WebGL2 renderer: shadow map, two-sided surfaces, opaque ones first, then those that are seen through, ground grid.

const LIGHT = normalize3([0.42, -0.38, 0.86]);

function normalize3(v) {
  const s = 1 / Math.hypot(...v);
  return v.map((c) => c * s);
}
const cross3 = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const dot3 = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const NEUTRAL = [0.8, 0.81, 0.83]; // of bodies without values, where a field is shown
// Axes of the scene, x, y and up, of which up is against gravity: as upright() of stark.render.camera.
function uprightAxes(up) {
  const x = up[0] ? [0, up[0], 0] : [1, 0, 0];
  return [x, cross3(up, x), up];
}
const alongAxes = (axes, v) => [0, 1, 2].map((a) => axes[0][a] * v[0] + axes[1][a] * v[1] + axes[2][a] * v[2]);
const IDENTITY = new Float32Array([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);

function multiply(a, b) {
  const c = new Float32Array(16);
  for (let i = 0; i < 4; ++i)
    for (let j = 0; j < 4; ++j) for (let k = 0; k < 4; ++k) c[4 * j + i] += a[4 * k + i] * b[4 * j + k];
  return c;
}

function lookAt(eye, target, up) {
  const back = normalize3([0, 1, 2].map((i) => eye[i] - target[i]));
  const right = normalize3(cross3(up, back)), top = cross3(back, right);
  return new Float32Array([
    right[0], top[0], back[0], 0, right[1], top[1], back[1], 0, right[2], top[2], back[2], 0,
    -dot3(right, eye), -dot3(top, eye), -dot3(back, eye), 1,
  ]);
}

function perspective(fov, aspect, near, far) {
  const f = 1 / Math.tan(fov / 2), d = 1 / (near - far);
  return new Float32Array([f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) * d, -1, 0, 0, 2 * far * near * d, 0]);
}

function orthographic(radius, near, far) {
  const d = 1 / (near - far), s = 1 / radius;
  return new Float32Array([s, 0, 0, 0, 0, s, 0, 0, 0, 0, 2 * d, 0, 0, 0, (far + near) * d, 1]);
}

class Renderer {
  constructor(canvas, bodies, bounds) {
    const gl = canvas.getContext("webgl2", { antialias: true, alpha: true, stencil: true, preserveDrawingBuffer: true });
    if (!gl) throw new Error("This browser offers no WebGL2. Try a current Firefox, Chrome, Edge or Safari.");
    this.gl = gl;
    this.canvas = canvas;
    this.bodies = bodies;
    this.bounds = bounds;
    this.light = alongAxes(bounds.axes, LIGHT);
    this.surface = this.program(SURFACE_VERTEX, SURFACE_FRAGMENT);
    this.line = this.program(SURFACE_VERTEX, LINE_FRAGMENT);
    this.depth = this.program(SURFACE_VERTEX, DEPTH_FRAGMENT);
    this.ground = this.program(GROUND_VERTEX, GROUND_FRAGMENT);
    this.makeShadowMap();
    this.colormap = gl.createTexture();
    this.clip = [0, 0, 0, 1];
    for (const body of bodies) this.upload(body);
    this.emptyArray = gl.createVertexArray();
    this.caps = new Caps(this);
  }

  program(vertex, fragment) {
    const gl = this.gl, program = gl.createProgram();
    for (const [type, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(type);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
    const uniforms = {};
    for (let i = 0; i < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); ++i) {
      const { name } = gl.getActiveUniform(program, i);
      uniforms[name] = gl.getUniformLocation(program, name);
    }
    return { program, ...uniforms };
  }

  // Colours [[r, g, b], ...] in [0, 1], evenly spaced, as a texture of 256 pixels.
  setColormap(points) {
    const gl = this.gl, pixels = new Uint8Array(4 * 256);
    for (let i = 0; i < 256; ++i) pixels.set([...colorAt(points, i / 255).map((c) => Math.round(255 * c)), 255], 4 * i);
    gl.bindTexture(gl.TEXTURE_2D, this.colormap);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, 256, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, gl.LINEAR);
    for (const name of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, name, gl.CLAMP_TO_EDGE);
  }

  makeShadowMap() {
    const gl = this.gl;
    this.shadowTexture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.shadowTexture);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.DEPTH_COMPONENT24, SHADOW_SIZE, SHADOW_SIZE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_COMPARE_MODE, gl.COMPARE_REF_TO_TEXTURE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
    this.shadowFrame = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.shadowFrame);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, this.shadowTexture, 0);
    gl.drawBuffers([gl.NONE]);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    const { center, radius, axes } = this.bounds, reach = 2.2 * radius;
    const eye = [0, 1, 2].map((i) => center[i] + this.light[i] * 2 * reach);
    const matrix = multiply(orthographic(reach, 0.1 * reach, 4 * reach), lookAt(eye, center, axes[1]));
    this.lightMatrix = matrix;
    const half = new Float32Array([0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 0.5, 0, 0.5, 0.5, 0.5, 1]);
    this.shadowMatrix = multiply(half, matrix);
  }

  upload(body) {
    const gl = this.gl;
    const mesh = renderMesh(body.triangles, body.rest, body.isSheet ? -2 : Math.cos(0.65));
    body.mesh = mesh;
    body.positions = new Float32Array(body.rest);
    body.scratch = new Float32Array(body.rest.length);
    body.vertexData = new Float32Array(6 * mesh.source.length);
    body.values = null;
    body.valueData = new Float32Array(mesh.source.length);
    body.model = IDENTITY;
    body.array = gl.createVertexArray();
    gl.bindVertexArray(body.array);
    body.vertexBuffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, body.vertexBuffer);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 24, 0);
    gl.enableVertexAttribArray(1);
    gl.vertexAttribPointer(1, 3, gl.FLOAT, false, 24, 12);
    body.valueBuffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, body.valueBuffer);
    gl.bufferData(gl.ARRAY_BUFFER, body.valueData, gl.DYNAMIC_DRAW);
    gl.enableVertexAttribArray(2);
    gl.vertexAttribPointer(2, 1, gl.FLOAT, false, 4, 0);
    body.triangleBuffer = gl.createBuffer();
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, body.triangleBuffer);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, mesh.index, gl.STATIC_DRAW);
    gl.bindVertexArray(null);
    body.lineBuffer = gl.createBuffer();
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, body.lineBuffer);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, mesh.lines, gl.STATIC_DRAW);
    this.fill(body);
  }

  // Vertex normals (area weighted) of the current positions, then both to the device.
  fill(body) {
    const { index, source } = body.mesh, p = body.positions, v = body.vertexData;
    for (let i = 0; i < source.length; ++i) {
      const s = 3 * source[i], o = 6 * i;
      v[o] = p[s]; v[o + 1] = p[s + 1]; v[o + 2] = p[s + 2];
      v[o + 3] = v[o + 4] = v[o + 5] = 0;
    }
    for (let t = 0; t < index.length; t += 3) {
      const a = 6 * index[t], b = 6 * index[t + 1], c = 6 * index[t + 2];
      const ux = v[b] - v[a], uy = v[b + 1] - v[a + 1], uz = v[b + 2] - v[a + 2];
      const wx = v[c] - v[a], wy = v[c + 1] - v[a + 1], wz = v[c + 2] - v[a + 2];
      const nx = uy * wz - uz * wy, ny = uz * wx - ux * wz, nz = ux * wy - uy * wx;
      v[a + 3] += nx; v[a + 4] += ny; v[a + 5] += nz;
      v[b + 3] += nx; v[b + 4] += ny; v[b + 5] += nz;
      v[c + 3] += nx; v[c + 4] += ny; v[c + 5] += nz;
    }
    for (let o = 3; o < v.length; o += 6) {
      const s = 1 / (Math.hypot(v[o], v[o + 1], v[o + 2]) || 1);
      v[o] *= s; v[o + 1] *= s; v[o + 2] *= s;
    }
    this.gl.bindBuffer(this.gl.ARRAY_BUFFER, body.vertexBuffer);
    this.gl.bufferData(this.gl.ARRAY_BUFFER, v, this.gl.DYNAMIC_DRAW);
  }

  // Moves all bodies to frame k + f, with the values of a field, if there is one.
  setFrame(k, f, field) {
    this.field = field;
    for (const body of this.bodies) {
      body.values = field ? valuesBetween(field, body, k, f) : null;
      if (body.values && body.visible) {
        const { source } = body.mesh;
        for (let i = 0; i < source.length; ++i) body.valueData[i] = body.values[source[i]];
        this.gl.bindBuffer(this.gl.ARRAY_BUFFER, body.valueBuffer);
        this.gl.bufferData(this.gl.ARRAY_BUFFER, body.valueData, this.gl.DYNAMIC_DRAW);
      }
      if (body.mode === "mesh" && body.visible) {
        positionsBetween(body, k, f, body.positions, body.scratch);
        this.fill(body);
      } else if (body.mode === "rigid") {
        body.model = poseBetween(body, k, f);
      }
    }
  }

  // Bodies that `wanted` keeps; ground and grid are not cut.
  drawBodies(program, matrix, lines, wanted) {
    const gl = this.gl;
    gl.uniformMatrix4fv(program.viewProjection, false, matrix);
    const { center, radius } = this.bounds;
    for (const body of this.bodies) {
      if (!body.visible || !wanted(body) || (lines && body.scenery)) continue;
      const values = body.values !== null;
      if (program.horizon) gl.uniform4f(program.horizon, ...center, body.scenery ? 9 * radius : 0);
      gl.uniform4fv(program.clip, body.scenery ? [0, 0, 0, 1] : this.clip);
      gl.uniformMatrix4fv(program.model, false, body.model);
      if (program.color) gl.uniform3fv(program.color, this.field && !values ? NEUTRAL : body.color);
      if (program.hasField) gl.uniform1f(program.hasField, values ? 1 : 0);
      if (program.opacity) gl.uniform1f(program.opacity, body.opacity);
      if (program.marked) gl.uniform1f(program.marked, body.marked && !values ? 1 : 0);
      if (program.backTint) gl.uniform1f(program.backTint, body.isSheet ? 0.35 : 0);
      gl.bindVertexArray(body.array);
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, lines ? body.lineBuffer : body.triangleBuffer);
      if (lines) gl.drawElements(gl.LINES, body.mesh.lines.length, gl.UNSIGNED_INT, 0);
      else gl.drawElements(gl.TRIANGLES, body.mesh.index.length, gl.UNSIGNED_INT, 0);
    }
    gl.bindVertexArray(null);
  }

  draw(camera, options) {
    const gl = this.gl, { center, radius, ground, axes } = this.bounds;
    gl.enable(gl.DEPTH_TEST);
    gl.disable(gl.CULL_FACE);
    if (options.shadows) {
      gl.bindFramebuffer(gl.FRAMEBUFFER, this.shadowFrame);
      gl.viewport(0, 0, SHADOW_SIZE, SHADOW_SIZE);
      gl.clear(gl.DEPTH_BUFFER_BIT);
      gl.useProgram(this.depth.program);
      gl.enable(gl.POLYGON_OFFSET_FILL);
      gl.polygonOffset(1.5, 2);
      this.drawBodies(this.depth, this.lightMatrix, false, (body) => body.opacity >= 0.5);
      gl.disable(gl.POLYGON_OFFSET_FILL);
      gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    }
    const width = Math.max(1, Math.round(this.canvas.clientWidth * devicePixelRatio));
    const height = Math.max(1, Math.round(this.canvas.clientHeight * devicePixelRatio));
    if (this.canvas.width !== width) this.canvas.width = width;
    if (this.canvas.height !== height) this.canvas.height = height;
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const eye = camera.eye();
    const far = camera.distance + 30 * radius, near = Math.max(camera.distance * 0.02, 1e-3 * radius);
    const matrix = (this.matrix = multiply(perspective(camera.fov, width / height, near, far), lookAt(eye, camera.target, camera.up())));
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.shadowTexture);
    const surface = this.surface;
    gl.useProgram(surface.program);
    gl.uniformMatrix4fv(surface.shadowMatrix, false, this.shadowMatrix);
    gl.uniform1i(surface.shadowMap, 0);
    gl.uniform1f(surface.shadowStrength, options.shadows ? 1 : 0);
    gl.uniform3fv(surface.eye, eye);
    gl.uniform3fv(surface.light, this.light);
    gl.uniform3fv(surface.up, axes[2]);
    gl.uniform1f(surface.flatShading, options.flat ? 1 : 0);
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.polygonOffset(1, 1);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_2D, this.colormap);
    gl.activeTexture(gl.TEXTURE0);
    gl.uniform1i(surface.colormap, 1);
    gl.uniform2fv(surface.limits, this.field ? this.field.limits : [0, 1]);
    this.drawBodies(surface, matrix, false, (body) => body.opacity >= 1);
    this.caps.draw(matrix);
    gl.disable(gl.POLYGON_OFFSET_FILL);
    if (options.edges) {
      gl.useProgram(this.line.program);
      gl.uniform4f(this.line.lineColor, 0.06, 0.09, 0.14, 0.38);
      this.drawBodies(this.line, matrix, true, (body) => body.opacity > 0);
    }
    this.drawThin(matrix);
    if (options.grid) {
      const program = this.ground;
      gl.useProgram(program.program);
      gl.uniformMatrix4fv(program.viewProjection, false, matrix);
      gl.uniformMatrix4fv(program.shadowMatrix, false, this.shadowMatrix);
      gl.uniform1i(program.shadowMap, 0);
      gl.uniform1f(program.shadowStrength, options.shadows ? 1 : 0);
      gl.uniformMatrix3fv(program.axes, false, axes.flat());
      gl.uniform4f(program.ground, dot3(center, axes[0]), dot3(center, axes[1]), ground, 8 * radius);
      gl.uniform1f(program.onFloor, this.bodies.some((b) => b.scenery && b.visible) ? 1 : 0);
      gl.uniform1f(program.spacing, Math.pow(10, Math.floor(Math.log10(0.8 * radius))));
      gl.depthMask(false);
      gl.bindVertexArray(this.emptyArray);
      gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
      gl.bindVertexArray(null);
      gl.depthMask(true);
    }
    gl.disable(gl.BLEND);
  }

  // Bodies that are seen through: first their depth, so that each shows its nearest surface only.
  drawThin(matrix) {
    const gl = this.gl, thin = (body) => body.opacity > 0 && body.opacity < 1;
    if (!this.bodies.some((body) => body.visible && thin(body))) return;
    gl.colorMask(false, false, false, false);
    gl.useProgram(this.depth.program);
    this.drawBodies(this.depth, matrix, false, thin);
    gl.colorMask(true, true, true, true);
    gl.depthFunc(gl.LEQUAL);
    gl.useProgram(this.surface.program);
    this.drawBodies(this.surface, matrix, false, thin);
    gl.depthFunc(gl.LESS);
  }
}
