// The WebGL2 renderer: shadow map, hemisphere light with one soft-shadowed key light, two-sided surfaces, ground grid.

const LIGHT = normalize3([0.42, -0.38, 0.86]);
const SHADOW_SIZE = 2048;

const SURFACE_VERTEX = `#version 300 es
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
uniform mat4 viewProjection, model, shadowMatrix;
out vec3 worldPosition, worldNormal, shadowPosition;
void main() {
  vec4 p = model * vec4(position, 1.0);
  worldPosition = p.xyz;
  worldNormal = mat3(model) * normal;
  shadowPosition = (shadowMatrix * p).xyz;
  gl_Position = viewProjection * p;
}`;

const SHADOW_LOOKUP = `
uniform highp sampler2DShadow shadowMap;
uniform float shadowStrength;
float lit(vec3 p, float bias) {
  if (shadowStrength == 0.0 || any(lessThan(p, vec3(0.0))) || any(greaterThan(p, vec3(1.0)))) return 1.0;
  float sum = 0.0, texel = 1.6 / ${SHADOW_SIZE}.0;
  for (int i = -2; i <= 2; ++i)
    for (int j = -2; j <= 2; ++j) sum += texture(shadowMap, vec3(p.xy + texel * vec2(i, j), p.z - bias));
  return mix(1.0, sum / 25.0, shadowStrength);
}`;

const SURFACE_FRAGMENT = `#version 300 es
precision highp float;
in vec3 worldPosition, worldNormal, shadowPosition;
uniform vec3 color, eye, light;
uniform float flatShading, backTint;
uniform vec4 horizon;
out vec4 fragment;
${SHADOW_LOOKUP}
void main() {
  vec3 view = normalize(eye - worldPosition);
  vec3 face = normalize(cross(dFdx(worldPosition), dFdy(worldPosition)));
  vec3 n = flatShading > 0.5 ? face : normalize(worldNormal);
  if (dot(face, view) < 0.0) face = -face;
  if (dot(n, face) < 0.0) n = -n;
  vec3 base = pow(color, vec3(2.2));
  if (!gl_FrontFacing) base = mix(base, vec3(dot(base, vec3(0.3, 0.55, 0.15))) * 1.15, backTint);
  float key = max(dot(n, light), 0.0);
  float shadow = lit(shadowPosition, 0.0008 + 0.004 * (1.0 - key)) * smoothstep(-0.05, 0.12, dot(face, light));
  vec3 sky = vec3(0.50, 0.54, 0.60), earth = vec3(0.30, 0.28, 0.27);
  vec3 ambient = mix(earth, sky, 0.5 + 0.5 * n.z);
  float fill = 0.10 * max(dot(n, view), 0.0);
  vec3 halfway = normalize(light + view);
  float gloss = 0.10 * pow(max(dot(n, halfway), 0.0), 42.0) * shadow;
  vec3 c = base * (ambient + fill + vec3(0.80, 0.77, 0.73) * key * shadow) + gloss;
  c = 1.12 * c / (1.0 + 0.22 * c);
  float alpha = 1.0;
  if (horizon.w > 0.0) alpha -= smoothstep(0.35, 1.0, distance(worldPosition, horizon.xyz) / horizon.w);
  fragment = vec4(pow(min(c, vec3(1.0)), vec3(1.0 / 2.2)) * alpha, alpha);
}`;

const LINE_FRAGMENT = `#version 300 es
precision highp float;
in vec3 worldPosition, worldNormal, shadowPosition;
uniform vec4 lineColor;
out vec4 fragment;
void main() { fragment = vec4(lineColor.rgb * lineColor.a, lineColor.a); }`;

const DEPTH_FRAGMENT = `#version 300 es
precision highp float;
void main() {}`;

const GROUND_VERTEX = `#version 300 es
uniform mat4 viewProjection, shadowMatrix;
uniform vec4 ground;
out vec3 worldPosition, shadowPosition;
void main() {
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
  worldPosition = vec3(ground.xy + corner * ground.w, ground.z);
  shadowPosition = (shadowMatrix * vec4(worldPosition, 1.0)).xyz;
  gl_Position = viewProjection * vec4(worldPosition, 1.0);
}`;

const GROUND_FRAGMENT = `#version 300 es
precision highp float;
in vec3 worldPosition, shadowPosition;
uniform vec4 ground;
uniform float spacing, onFloor;
out vec4 fragment;
${SHADOW_LOOKUP}
float lines(float every) {
  vec2 p = worldPosition.xy / every, w = fwidth(p);
  vec2 d = abs(fract(p - 0.5) - 0.5) / max(w, 1e-6);
  vec2 fade = clamp(1.0 - w * 2.5, 0.0, 1.0);
  vec2 on = (1.0 - clamp(d - 0.1, 0.0, 1.0)) * fade;
  return max(on.x, on.y);
}
void main() {
  float r = length(worldPosition.xy - ground.xy) / ground.w;
  float fade = 1.0 - smoothstep(0.25, 1.0, r);
  float a = max(0.13 * lines(spacing), 0.26 * lines(10.0 * spacing)) * fade;
  float dark = onFloor > 0.5 ? 0.0 : 0.30 * (1.0 - lit(shadowPosition, 0.0005)) * fade;
  float alpha = 1.0 - (1.0 - a) * (1.0 - dark);
  fragment = vec4(vec3(0.28, 0.33, 0.40) * alpha, alpha);
}`;

function normalize3(v) {
  const s = 1 / Math.hypot(...v);
  return v.map((c) => c * s);
}
const cross3 = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const dot3 = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
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
    const gl = canvas.getContext("webgl2", { antialias: true, alpha: true, preserveDrawingBuffer: true });
    if (!gl) throw new Error("This browser offers no WebGL2. Try a current Firefox, Chrome, Edge or Safari.");
    this.gl = gl;
    this.canvas = canvas;
    this.bodies = bodies;
    this.bounds = bounds;
    this.surface = this.program(SURFACE_VERTEX, SURFACE_FRAGMENT);
    this.line = this.program(SURFACE_VERTEX, LINE_FRAGMENT);
    this.depth = this.program(SURFACE_VERTEX, DEPTH_FRAGMENT);
    this.ground = this.program(GROUND_VERTEX, GROUND_FRAGMENT);
    this.makeShadowMap();
    for (const body of bodies) this.upload(body);
    this.emptyArray = gl.createVertexArray();
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
    const { center, radius } = this.bounds, reach = 2.2 * radius;
    const eye = [0, 1, 2].map((i) => center[i] + LIGHT[i] * 2 * reach);
    const matrix = multiply(orthographic(reach, 0.1 * reach, 4 * reach), lookAt(eye, center, [0, 1, 0]));
    this.lightMatrix = matrix;
    const half = new Float32Array([0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 0.5, 0, 0.5, 0.5, 0.5, 1]);
    this.shadowMatrix = multiply(half, matrix);
  }

  upload(body) {
    const gl = this.gl;
    const mesh = renderMesh(body.triangles, body.rest, body.kind === "cloth" ? -2 : Math.cos(0.65));
    body.mesh = mesh;
    body.positions = new Float32Array(body.rest);
    body.scratch = new Float32Array(body.rest.length);
    body.vertexData = new Float32Array(6 * mesh.source.length);
    body.model = IDENTITY;
    body.array = gl.createVertexArray();
    gl.bindVertexArray(body.array);
    body.vertexBuffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, body.vertexBuffer);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 24, 0);
    gl.enableVertexAttribArray(1);
    gl.vertexAttribPointer(1, 3, gl.FLOAT, false, 24, 12);
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

  // Moves all bodies to frame k + f.
  setFrame(k, f) {
    for (const body of this.bodies) {
      if (body.mode === "mesh" && body.visible) {
        positionsBetween(body, k, f, body.positions, body.scratch);
        this.fill(body);
      } else if (body.mode === "rigid") {
        body.model = poseBetween(body, k, f);
      }
    }
  }

  drawBodies(program, matrix, lines) {
    const gl = this.gl;
    gl.uniformMatrix4fv(program.viewProjection, false, matrix);
    const { center, radius } = this.bounds;
    for (const body of this.bodies) {
      if (!body.visible || (lines && body.scenery)) continue;
      if (program.horizon) gl.uniform4f(program.horizon, ...center, body.scenery ? 9 * radius : 0);
      gl.uniformMatrix4fv(program.model, false, body.model);
      if (program.color) gl.uniform3fv(program.color, body.color);
      if (program.backTint) gl.uniform1f(program.backTint, body.kind === "cloth" ? 0.35 : 0);
      gl.bindVertexArray(body.array);
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, lines ? body.lineBuffer : body.triangleBuffer);
      if (lines) gl.drawElements(gl.LINES, body.mesh.lines.length, gl.UNSIGNED_INT, 0);
      else gl.drawElements(gl.TRIANGLES, body.mesh.index.length, gl.UNSIGNED_INT, 0);
    }
    gl.bindVertexArray(null);
  }

  draw(camera, options) {
    const gl = this.gl, { center, radius, ground } = this.bounds;
    gl.enable(gl.DEPTH_TEST);
    gl.disable(gl.CULL_FACE);
    if (options.shadows) {
      gl.bindFramebuffer(gl.FRAMEBUFFER, this.shadowFrame);
      gl.viewport(0, 0, SHADOW_SIZE, SHADOW_SIZE);
      gl.clear(gl.DEPTH_BUFFER_BIT);
      gl.useProgram(this.depth.program);
      gl.enable(gl.POLYGON_OFFSET_FILL);
      gl.polygonOffset(1.5, 2);
      this.drawBodies(this.depth, this.lightMatrix, false);
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
    const matrix = multiply(perspective(camera.fov, width / height, near, far), lookAt(eye, camera.target, camera.up()));
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.shadowTexture);
    const surface = this.surface;
    gl.useProgram(surface.program);
    gl.uniformMatrix4fv(surface.shadowMatrix, false, this.shadowMatrix);
    gl.uniform1i(surface.shadowMap, 0);
    gl.uniform1f(surface.shadowStrength, options.shadows ? 1 : 0);
    gl.uniform3fv(surface.eye, eye);
    gl.uniform3fv(surface.light, LIGHT);
    gl.uniform1f(surface.flatShading, options.flat ? 1 : 0);
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.polygonOffset(1, 1);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    this.drawBodies(surface, matrix, false);
    gl.disable(gl.POLYGON_OFFSET_FILL);
    if (options.edges) {
      gl.useProgram(this.line.program);
      gl.uniform4f(this.line.lineColor, 0.06, 0.09, 0.14, 0.38);
      this.drawBodies(this.line, matrix, true);
    }
    if (options.grid) {
      const program = this.ground;
      gl.useProgram(program.program);
      gl.uniformMatrix4fv(program.viewProjection, false, matrix);
      gl.uniformMatrix4fv(program.shadowMatrix, false, this.shadowMatrix);
      gl.uniform1i(program.shadowMap, 0);
      gl.uniform1f(program.shadowStrength, options.shadows ? 1 : 0);
      gl.uniform4f(program.ground, center[0], center[1], ground, 8 * radius);
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
}
