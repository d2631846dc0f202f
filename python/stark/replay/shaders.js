// The shaders: hemisphere light with one soft-shadowed key light, values as colours, a clip plane, the ground grid.

const SHADOW_SIZE = 2048;

const CLIP = `
uniform vec4 clip;  // normal and offset: what lies beyond the plane is not drawn
void cut(vec3 p) { if (dot(clip.xyz, p) > clip.w) discard; }`;

const SURFACE_VERTEX = `#version 300 es
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in float value;
uniform mat4 viewProjection, model, shadowMatrix;
out vec3 worldPosition, worldNormal, shadowPosition;
out float fieldValue;
invariant gl_Position;
void main() {
  fieldValue = value;
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
in float fieldValue;
uniform vec3 color, eye, light, up;
uniform float flatShading, backTint, opacity, marked, hasField;
uniform vec2 limits;
uniform sampler2D colormap;
uniform vec4 horizon;
out vec4 fragment;
${SHADOW_LOOKUP}
${CLIP}
void main() {
  cut(worldPosition);
  vec3 view = normalize(eye - worldPosition);
  vec3 face = normalize(cross(dFdx(worldPosition), dFdy(worldPosition)));
  vec3 n = flatShading > 0.5 ? face : normalize(worldNormal);
  if (dot(face, view) < 0.0) face = -face;
  if (dot(n, face) < 0.0) n = -n;
  vec3 shade = color;
  if (hasField > 0.5) {
    float share = clamp((fieldValue - limits.x) / (limits.y - limits.x), 0.0, 1.0);
    shade = texture(colormap, vec2((0.5 + 255.0 * share) / 256.0, 0.5)).rgb;
  }
  vec3 base = pow(shade, vec3(2.2));
  if (!gl_FrontFacing) base = mix(base, vec3(dot(base, vec3(0.3, 0.55, 0.15))) * 1.15, backTint * (1.0 - hasField));
  float key = max(dot(n, light), 0.0);
  float shadow = lit(shadowPosition, 0.0008 + 0.004 * (1.0 - key)) * smoothstep(-0.05, 0.12, dot(face, light));
  vec3 sky = vec3(0.50, 0.54, 0.60), earth = vec3(0.30, 0.28, 0.27);
  vec3 ambient = mix(earth, sky, 0.5 + 0.5 * dot(n, up));
  float fill = 0.10 * max(dot(n, view), 0.0);
  vec3 halfway = normalize(light + view);
  float gloss = 0.10 * pow(max(dot(n, halfway), 0.0), 42.0) * shadow;
  vec3 c = base * (ambient + fill + vec3(0.80, 0.77, 0.73) * key * shadow) + gloss;
  c = 1.12 * c / (1.0 + 0.22 * c);
  float rim = marked * pow(1.0 - abs(dot(n, view)), 2.0);
  c = mix(c, vec3(0.03, 0.16, 0.72), 0.85 * rim);
  float alpha = opacity;
  if (horizon.w > 0.0) alpha *= 1.0 - smoothstep(0.35, 1.0, distance(worldPosition, horizon.xyz) / horizon.w);
  fragment = vec4(pow(min(c, vec3(1.0)), vec3(1.0 / 2.2)) * alpha, alpha);
}`;

const LINE_FRAGMENT = `#version 300 es
precision highp float;
in vec3 worldPosition, worldNormal, shadowPosition;
uniform vec4 lineColor;
out vec4 fragment;
${CLIP}
void main() { cut(worldPosition); fragment = vec4(lineColor.rgb * lineColor.a, lineColor.a); }`;

const DEPTH_FRAGMENT = `#version 300 es
precision highp float;
in vec3 worldPosition;
${CLIP}
void main() { cut(worldPosition); }`;

const GROUND_VERTEX = `#version 300 es
uniform mat4 viewProjection, shadowMatrix;
uniform mat3 axes;  // x, y and up of the scene
uniform vec4 ground;
out vec2 place;
out vec3 shadowPosition;
void main() {
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
  place = ground.xy + corner * ground.w;
  vec3 worldPosition = axes * vec3(place, ground.z);
  shadowPosition = (shadowMatrix * vec4(worldPosition, 1.0)).xyz;
  gl_Position = viewProjection * vec4(worldPosition, 1.0);
}`;

const GROUND_FRAGMENT = `#version 300 es
precision highp float;
in vec2 place;
in vec3 shadowPosition;
uniform vec4 ground;
uniform float spacing, onFloor;
out vec4 fragment;
${SHADOW_LOOKUP}
float lines(float every) {
  vec2 p = place / every, w = fwidth(p);
  vec2 d = abs(fract(p - 0.5) - 0.5) / max(w, 1e-6);
  vec2 fade = clamp(1.0 - w * 2.5, 0.0, 1.0);
  vec2 on = (1.0 - clamp(d - 0.1, 0.0, 1.0)) * fade;
  return max(on.x, on.y);
}
void main() {
  float r = length(place - ground.xy) / ground.w;
  float fade = 1.0 - smoothstep(0.25, 1.0, r);
  float a = max(0.13 * lines(spacing), 0.26 * lines(10.0 * spacing)) * fade;
  float dark = onFloor > 0.5 ? 0.0 : 0.30 * (1.0 - lit(shadowPosition, 0.0005)) * fade;
  float alpha = 1.0 - (1.0 - a) * (1.0 - dark);
  fragment = vec4(vec3(0.28, 0.33, 0.40) * alpha, alpha);
}`;
