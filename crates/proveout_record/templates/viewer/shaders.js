// Programs of the graphics card: bodies, what lies under a point, stretches of a path, the face of a section.
const Shaders = (() => {
  'use strict';
  const place = `layout(location=0) in vec3 position; layout(location=1) in vec3 normal; layout(location=2) in float value;
    layout(location=3) in uint block; layout(location=4) in float tag;
    uniform mat4 clip; uniform mat3 turn; uniform vec3 low, size; uniform vec4 plane; out float beyond;`;
  const put = 'vec3 p = low + size * position; gl_Position = clip * vec4(p, 1.0); beyond = dot(plane.xyz, p) - plane.w;';
  const cut = 'in float beyond;';
  const shown = [`${place} uniform int mode; uniform vec2 range; uniform uvec2 marked; out vec3 n; out float s, known, lit;
    void main() {
      ${put} n = turn * normal; s = 0.5; known = 0.0;
      lit = block >= marked.x && block <= marked.y ? 1.0 : 0.0;
      if (mode == 1 && value < 0.999) { known = 1.0; s = value * 255.0 / 254.0; }
      if (mode == 2 && value < 6e4) { known = 1.0; s = clamp(0.5 + 0.5 * value / (value < 0.0 ? range.x : range.y), -1.0, 2.0); }
      if (mode == 3) { known = 1.0; s = tag; }
    }`, `${cut} in vec3 n; in float s, known, lit; uniform sampler2D map, tags; uniform vec3 plain; uniform float alpha; uniform int mode; out vec4 color;
    void main() {
      if (beyond > 0.0) discard;
      vec3 base = plain;
      if (known > 0.99) base = texture(map, vec2(s * 255.0 / 256.0 + 0.5 / 256.0, 0.5)).rgb;
      if (mode == 3) base = texelFetch(tags, ivec2(int(s * 255.0 + 0.5), 0), 0).rgb;
      base = mix(base, vec3(1.0, 0.55, 0.1), 0.75 * smoothstep(0.3, 0.9, lit));
      vec3 d = normalize(n);
      if (!gl_FrontFacing) { d = -d; base *= 0.6; }
      float head = max(d.z, 0.0);
      float key = max(dot(d, normalize(vec3(-0.4, 0.7, 0.6))), 0.0);
      float shine = pow(max(dot(d, normalize(vec3(-0.2, 0.35, 0.9))), 0.0), 40.0);
      color = vec4(base * (0.34 + 0.38 * head + 0.34 * key) + 0.10 * shine, alpha);
    }`];
  const picked = [`${place} flat out uint made; out float away, deviation;
    void main() { ${put} away = gl_Position.w; made = block; deviation = value; }`,
  `${cut} flat in uint made; in float away, deviation; uniform uint kind; out uvec4 found;
    void main() { if (beyond > 0.0) discard; found = uvec4(made, floatBitsToUint(away), floatBitsToUint(deviation), kind); }`];
  const drawn = [`layout(location=0) in vec3 from; layout(location=1) in vec3 to; layout(location=2) in float kind;
    uniform mat4 clip; uniform vec2 canvas; uniform float width; out float k;
    void main() {
      vec4 a = clip * vec4(from, 1.0), b = clip * vec4(to, 1.0);
      vec2 way = (b.xy / b.w - a.xy / a.w) * canvas;
      vec2 side = length(way) > 1e-6 ? normalize(vec2(-way.y, way.x)) : vec2(0.0, 1.0);
      vec4 p = gl_VertexID < 2 ? a : b;
      p.xy += side * (gl_VertexID % 2 == 0 ? width : -width) / canvas * p.w;
      p.z -= 2e-4 * p.w;
      gl_Position = p; k = kind;
    }`, 'in float k; uniform vec3 feed, rapid; uniform float alpha; out vec4 color; void main() { color = vec4(k > 0.5 ? rapid : feed, alpha); }'];
  // A square on the plane of a section: hatched in points of the screen
  const face = ['layout(location=0) in vec3 position; uniform mat4 clip; out float away; void main() { gl_Position = clip * vec4(position, 1.0); away = gl_Position.w; }',
    `uniform vec3 plain; out vec4 color;
    void main() { float h = mod(gl_FragCoord.x + gl_FragCoord.y, 14.0); color = vec4(plain * (h < 2.0 ? 0.62 : 0.86), 1.0); }`];
  const facePicked = [face[0], `in float away; out uvec4 found;
    void main() { found = uvec4(0u, floatBitsToUint(away), 0x7f800000u, 2u); }`];
  return { shown, picked, drawn, face, facePicked };
})();
