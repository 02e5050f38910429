// Viewer of the cut part: orbit, pan, zoom; colors by deviation, markers that hide behind walls, what was clicked. Reads what encode.rs and path.rs pack.
const bytesOf = (text) => Uint8Array.from(atob(text.trim()), (c) => c.charCodeAt(0));
const inflated = async (id) => {
  const element = document.getElementById(id);
  if (!element || !element.textContent.trim()) return null;
  const packed = new Blob([bytesOf(element.textContent)]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Uint8Array(await new Response(packed).arrayBuffer());
};
// Whole numbers written as their differences.
const numbersAt = (bytes, at, count, into) => {
  let last = 0;
  for (let i = 0; i < count; i++) {
    let code = 0, factor = 1, byte;
    do { byte = bytes[at++]; code += (byte & 127) * factor; factor *= 128; } while (byte > 127);
    last += code % 2 ? -(code + 1) / 2 : code / 2;
    into[i] = last;
  }
  return at;
};
const partView = (async () => {
  'use strict';
  const figure = document.getElementById('part-view');
  if (!figure) return null;
  const canvas = figure.querySelector('canvas');
  const note = figure.querySelector('.view-note');
  const data = JSON.parse(document.getElementById('part-data').textContent);
  const gl = canvas.getContext('webgl2', { antialias: true, preserveDrawingBuffer: true, alpha: true });
  if (!gl) {
    note.textContent = 'This browser shows no WebGL 2 graphics. The same shape is in part.glb and deviation.glb.';
    return null;
  }

  // Mesh
  const bytes = await inflated('part-mesh');
  const view = new DataView(bytes.buffer);
  const vertices = view.getUint32(0, true), triangles = view.getUint32(4, true);
  const low = [8, 12, 16].map((o) => view.getFloat32(o, true)), size = [20, 24, 28].map((o) => view.getFloat32(o, true));
  let at = 32;
  const cut = (length) => { const part = bytes.slice(at, at + length); at += length; return part; };
  const positions = new Uint16Array(cut(6 * vertices).buffer), normals = new Int8Array(cut(3 * vertices).buffer);
  const values = data.values ? new Uint16Array(cut(2 * vertices).buffer) : data.colored ? cut(vertices) : null;
  const lines = new Uint32Array(vertices);
  if (data.lines) at = numbersAt(bytes, at, vertices, lines);
  const indices = new Uint32Array(3 * triangles);
  numbersAt(bytes, at, indices.length, indices);
  const vertex = (i) => [0, 1, 2].map((k) => low[k] + size[k] * positions[3 * i + k] / 65535);

  // Programs: the part, what lies under a point, stretches of the path
  const compile = (kind, text) => { const s = gl.createShader(kind); gl.shaderSource(s, text); gl.compileShader(s); return s; };
  const linked = (vertexText, fragmentText) => {
    const program = gl.createProgram();
    gl.attachShader(program, compile(gl.VERTEX_SHADER, '#version 300 es\n' + vertexText));
    gl.attachShader(program, compile(gl.FRAGMENT_SHADER, '#version 300 es\nprecision highp float;\n' + fragmentText));
    gl.linkProgram(program);
    const slots = {};
    return { program, ok: gl.getProgramParameter(program, gl.LINK_STATUS), at: (name) => slots[name] ??= gl.getUniformLocation(program, name) };
  };
  const place = `layout(location=0) in vec3 position; layout(location=1) in vec3 normal; layout(location=2) in float value; layout(location=3) in uint line;
    uniform mat4 clip; uniform mat3 turn; uniform vec3 low, size;`;
  const shown = linked(`${place} uniform int mode; uniform vec2 range; out vec3 n; out float s, known;
    void main() {
      gl_Position = clip * vec4(low + size * position, 1.0); n = turn * normal; s = 0.5; known = 0.0;
      if (mode == 1 && value < 0.999) { known = 1.0; s = value * 255.0 / 254.0; }
      if (mode == 2 && value < 6e4) { known = 1.0; s = clamp(0.5 + 0.5 * value / (value < 0.0 ? range.x : range.y), -1.0, 2.0); }
    }`, `in vec3 n; in float s, known; uniform sampler2D map; uniform vec3 plain; uniform bool colored; out vec4 color;
    void main() {
      vec3 base = colored && known > 0.99 ? texture(map, vec2(s * 255.0 / 256.0 + 0.5 / 256.0, 0.5)).rgb : plain;
      vec3 d = normalize(n);
      if (!gl_FrontFacing) { d = -d; base *= 0.6; }
      float head = max(d.z, 0.0);
      float key = max(dot(d, normalize(vec3(-0.4, 0.7, 0.6))), 0.0);
      float shine = pow(max(dot(d, normalize(vec3(-0.2, 0.35, 0.9))), 0.0), 40.0);
      color = vec4(base * (0.34 + 0.38 * head + 0.34 * key) + 0.10 * shine, 1.0);
    }`);
  const picked = linked(`${place} flat out uint made; out float away, deviation;
    void main() { gl_Position = clip * vec4(low + size * position, 1.0); away = gl_Position.w; made = line; deviation = value; }`,
  `flat in uint made; in float away, deviation; out uvec4 found;
    void main() { found = uvec4(made, floatBitsToUint(away), floatBitsToUint(deviation), 1u); }`);
  const drawn = linked(`layout(location=0) in vec3 from; layout(location=1) in vec3 to; layout(location=2) in float kind;
    uniform mat4 clip; uniform vec2 canvas; uniform float width; out float k;
    void main() {
      vec4 a = clip * vec4(from, 1.0), b = clip * vec4(to, 1.0);
      vec2 way = (b.xy / b.w - a.xy / a.w) * canvas;
      vec2 side = length(way) > 1e-6 ? normalize(vec2(-way.y, way.x)) : vec2(0.0, 1.0);
      vec4 p = gl_VertexID < 2 ? a : b;
      p.xy += side * (gl_VertexID % 2 == 0 ? width : -width) / canvas * p.w;
      p.z -= 2e-4 * p.w;
      gl_Position = p; k = kind;
    }`, `in float k; uniform vec3 feed, rapid; uniform float alpha; out vec4 color; void main() { color = vec4(k > 0.5 ? rapid : feed, alpha); }`);
  if (!shown.ok || !picked.ok || !drawn.ok) { note.textContent = 'The 3D view could not start.'; return null; }
  const attribute = (slot, array, width, type, normalized, whole) => {
    const buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, array, gl.STATIC_DRAW);
    gl.enableVertexAttribArray(slot);
    if (whole) gl.vertexAttribIPointer(slot, width, type, 0, 0); else gl.vertexAttribPointer(slot, width, type, normalized, 0, 0);
    return buffer;
  };
  const body = gl.createVertexArray();
  gl.bindVertexArray(body);
  attribute(0, positions, 3, gl.UNSIGNED_SHORT, true);
  attribute(1, normals, 3, gl.BYTE, true);
  const valueBuffer = values && (data.values ? attribute(2, values, 1, gl.HALF_FLOAT, false) : attribute(2, values, 1, gl.UNSIGNED_BYTE, true));
  attribute(3, lines, 1, gl.UNSIGNED_INT, false, true);
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indices, gl.STATIC_DRAW);
  gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB, 256, 1, 0, gl.RGB, gl.UNSIGNED_BYTE, bytesOf(data.map));
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
  gl.enable(gl.DEPTH_TEST);
  const paths = { all: null, chosen: null };
  const setPath = (which, segments) => {
    const old = paths[which];
    if (old) { gl.deleteBuffer(old.buffer); gl.deleteVertexArray(old.array); }
    paths[which] = null;
    if (segments && segments.length) {
      const array = gl.createVertexArray(), buffer = gl.createBuffer();
      gl.bindVertexArray(array);
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, segments, gl.STATIC_DRAW);
      [[3, 0], [3, 12], [1, 24]].forEach(([width, offset], slot) => {
        gl.enableVertexAttribArray(slot);
        gl.vertexAttribPointer(slot, width, gl.FLOAT, false, 28, offset);
        gl.vertexAttribDivisor(slot, 1);
      });
      gl.bindVertexArray(null);
      paths[which] = { array, buffer, count: segments.length / 7 };
    }
    redraw();
  };

  // Camera: looks at `target` from `distance`; azimuth about Z, elevation above the XY plane, radian
  const radius = Math.max(Math.hypot(...size) / 2, 1e-3), lens = 0.5;
  const focus = data.focus || { target: low.map((v, k) => v + size[k] / 2), radius };
  const home = () => ({ target: [...focus.target], azimuth: -0.95, elevation: 0.5, distance: 1.06 * focus.radius / Math.sin(lens / 2) });
  let eye = home(), colored = Boolean(values), range = data.scales ? data.scales.map((s) => s[0]) : [1, 1], waiting = false;
  const axes = () => {
    const [sa, ca, se, ce] = [Math.sin(eye.azimuth), Math.cos(eye.azimuth), Math.sin(eye.elevation), Math.cos(eye.elevation)];
    return { right: [-sa, ca, 0], up: [-se * ca, -se * sa, ce], back: [ce * ca, ce * sa, se] };
  };
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  // Scales of the projection, and the matrix
  const projection = () => {
    const width = canvas.clientWidth, height = canvas.clientHeight, a = axes(), f = 1 / Math.tan(lens / 2), g = width < height ? f * width / height : f;
    const sx = g * height / width, sy = g;
    const near = Math.max(eye.distance - 2.5 * radius, 0.01 * radius), far = eye.distance + 4 * radius;
    const zs = (far + near) / (near - far), zt = 2 * far * near / (near - far);
    const shift = [a.right, a.up, a.back].map((v) => -dot(v, eye.target));
    shift[2] -= eye.distance;
    const clip = [];
    for (let k = 0; k < 3; k++) clip.push(sx * a.right[k], sy * a.up[k], zs * a.back[k], -a.back[k]);
    clip.push(sx * shift[0], sy * shift[1], zs * shift[2] + zt, -shift[2]);
    return { a, sx, sy, clip };
  };

  const marks = data.marks.map((mark) => {
    const button = document.createElement('a');
    button.className = 'mark ' + mark.severity;
    button.href = '#' + mark.id;
    button.title = mark.title;
    button.textContent = mark.label;
    figure.querySelector('.marks').append(button);
    return { ...mark, button };
  });

  const uniforms = (program, p) => {
    gl.useProgram(program.program);
    gl.uniformMatrix4fv(program.at('clip'), false, p.clip);
    gl.uniform3fv(program.at('low'), low);
    gl.uniform3fv(program.at('size'), size);
  };
  // What lies under each point of a small picture: line, distance, deviation
  const small = { frame: gl.createFramebuffer(), width: 0, height: 0, found: null };
  const look = (p) => {
    const width = Math.max(1, Math.round(canvas.clientWidth / 2)), height = Math.max(1, Math.round(canvas.clientHeight / 2));
    gl.bindFramebuffer(gl.FRAMEBUFFER, small.frame);
    if (small.width !== width || small.height !== height) {
      for (const [format, point] of [[gl.RGBA32UI, gl.COLOR_ATTACHMENT0], [gl.DEPTH_COMPONENT24, gl.DEPTH_ATTACHMENT]]) {
        const store = gl.createRenderbuffer();
        gl.bindRenderbuffer(gl.RENDERBUFFER, store);
        gl.renderbufferStorage(gl.RENDERBUFFER, format, width, height);
        gl.framebufferRenderbuffer(gl.FRAMEBUFFER, point, gl.RENDERBUFFER, store);
      }
      Object.assign(small, { width, height, found: new Uint32Array(4 * width * height) });
    }
    gl.viewport(0, 0, width, height);
    gl.clearBufferuiv(gl.COLOR, 0, [0, 0, 0, 0]);
    gl.clearBufferfv(gl.DEPTH, 0, [1]);
    uniforms(picked, p);
    gl.bindVertexArray(body);
    gl.drawElements(gl.TRIANGLES, indices.length, gl.UNSIGNED_INT, 0);
    gl.readPixels(0, 0, width, height, gl.RGBA_INTEGER, gl.UNSIGNED_INT, small.found);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  };
  const float = new DataView(new ArrayBuffer(4));
  const asFloat = (bits) => { float.setUint32(0, bits); return float.getFloat32(0); };
  // At a place of the canvas, CSS points from the upper left
  const under = (x, y) => {
    const i = Math.floor(x * small.width / canvas.clientWidth), j = small.height - 1 - Math.floor(y * small.height / canvas.clientHeight);
    if (i < 0 || j < 0 || i >= small.width || j >= small.height) return null;
    const [line, away, value, here] = small.found.subarray(4 * (j * small.width + i), 4 * (j * small.width + i) + 4);
    return here ? { line, away: asFloat(away), value: data.values && asFloat(value) < 6e4 ? asFloat(value) : null } : null;
  };

  const style = getComputedStyle(document.documentElement);
  const ink = (name) => { const c = style.getPropertyValue(name).trim().slice(1); return [0, 2, 4].map((k) => parseInt(c.slice(k, k + 2), 16) / 255); };
  function draw() {
    waiting = false;
    const width = canvas.clientWidth, height = canvas.clientHeight, ratio = Math.min(window.devicePixelRatio || 1, 2);
    if (!width || !height) return;
    if (canvas.width !== Math.round(width * ratio)) canvas.width = Math.round(width * ratio);
    if (canvas.height !== Math.round(height * ratio)) canvas.height = Math.round(height * ratio);
    const p = projection();
    if (marks.length) look(p);
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    uniforms(shown, p);
    gl.uniform3fv(shown.at('plain'), data.plain.map((c) => c / 255));
    gl.uniformMatrix3fv(shown.at('turn'), false, [0, 1, 2].flatMap((k) => [p.a.right[k], p.a.up[k], p.a.back[k]]));
    gl.uniform1i(shown.at('colored'), colored ? 1 : 0);
    gl.uniform1i(shown.at('mode'), data.values ? 2 : values ? 1 : 0);
    gl.uniform2fv(shown.at('range'), range);
    gl.bindVertexArray(body);
    gl.drawElements(gl.TRIANGLES, indices.length, gl.UNSIGNED_INT, 0);
    gl.useProgram(drawn.program);
    gl.uniformMatrix4fv(drawn.at('clip'), false, p.clip);
    gl.uniform2f(drawn.at('canvas'), canvas.width, canvas.height);
    gl.enable(gl.BLEND);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthMask(false);
    for (const [path, wide, feed, rapid] of [[paths.all, 0.8, ink('--cut'), ink('--rapid')], [paths.chosen, 2.6, ink('--fail'), ink('--rapid')]]) {
      if (!path) continue;
      gl.bindVertexArray(path.array);
      gl.uniform1f(drawn.at('width'), wide * ratio);
      gl.uniform3fv(drawn.at('feed'), feed);
      gl.uniform3fv(drawn.at('rapid'), rapid);
      // Behind the part it shows through.
      for (const [test, alpha] of [[gl.GREATER, 0.22], [gl.LEQUAL, 0.95]]) {
        gl.depthFunc(test);
        gl.uniform1f(drawn.at('alpha'), alpha);
        gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, path.count);
      }
    }
    gl.depthFunc(gl.LESS);
    gl.depthMask(true);
    gl.disable(gl.BLEND);
    for (const mark of marks) {
      const d = mark.point.map((v, k) => v - eye.target[k]);
      const [x, y, z] = [dot(d, p.a.right), dot(d, p.a.up), dot(d, p.a.back) - eye.distance];
      const inside = z < 0 && Math.abs(p.sx * x) < -z && Math.abs(p.sy * y) < -z;
      const left = (0.5 - 0.5 * p.sx * x / z) * width, top = (0.5 + 0.5 * p.sy * y / z) * height;
      const wall = inside && under(left, top);
      // A place in the material belongs to the surface over it.
      const hidden = wall && wall.away < -z - 0.03 * radius;
      mark.button.style.display = inside ? '' : 'none';
      mark.button.classList.toggle('behind', Boolean(hidden));
      if (inside) mark.button.style.transform = `translate(${left}px, ${top}px)`;
    }
    const triad = figure.querySelector('.triad');
    [[1, 0, 0], [0, 1, 0], [0, 0, 1]].forEach((axis, k) => {
      const x = 32 + 22 * dot(axis, p.a.right), y = 32 - 22 * dot(axis, p.a.up), line = triad.children[2 * k], name = triad.children[2 * k + 1];
      line.setAttribute('x2', x); line.setAttribute('y2', y);
      name.setAttribute('x', 32 + 1.3 * (x - 32)); name.setAttribute('y', 32 + 1.3 * (y - 32));
    });
  }
  function redraw() { if (!waiting) { waiting = true; requestAnimationFrame(draw); } }

  // Pointer: one turns, two (or right button, or Shift) move and zoom; a click without a way tells what is there
  const held = new Map(), clicked = [];
  let way = 0;
  const pan = (dx, dy) => {
    const a = axes(), s = 2 * eye.distance * Math.tan(lens / 2) / canvas.clientHeight;
    eye.target = eye.target.map((v, k) => v - s * dx * a.right[k] + s * dy * a.up[k]);
  };
  const zoom = (factor) => { eye.distance = Math.min(Math.max(eye.distance * factor, 0.05 * radius), 40 * radius); };
  canvas.addEventListener('pointerdown', (e) => { canvas.setPointerCapture(e.pointerId); if (!held.size) way = 0; held.set(e.pointerId, [e.clientX, e.clientY]); });
  canvas.addEventListener('pointermove', (e) => {
    const last = held.get(e.pointerId);
    if (!last) return;
    const dx = e.clientX - last[0], dy = e.clientY - last[1];
    way += Math.abs(dx) + Math.abs(dy);
    if (held.size === 2) {
      const other = [...held].find(([id]) => id !== e.pointerId)[1];
      const before = Math.hypot(last[0] - other[0], last[1] - other[1]), after = Math.hypot(e.clientX - other[0], e.clientY - other[1]);
      if (before > 0 && after > 0) zoom(before / after);
      pan(dx / 2, dy / 2);
    } else if (e.shiftKey || e.buttons & 6) pan(dx, dy);
    else {
      eye.azimuth -= 0.008 * dx;
      eye.elevation = Math.min(Math.max(eye.elevation + 0.008 * dy, -1.57), 1.57);
    }
    held.set(e.pointerId, [e.clientX, e.clientY]);
    redraw();
  });
  canvas.addEventListener('pointerup', (e) => {
    held.delete(e.pointerId);
    if (way > 4 || e.button !== 0) return;
    const p = projection(), box = canvas.getBoundingClientRect();
    look(p);
    redraw();
    const [x, y] = [e.clientX - box.left, e.clientY - box.top], hit = under(x, y);
    if (hit) {
      const [u, v] = [(2 * x / box.width - 1) / p.sx * hit.away, (1 - 2 * y / box.height) / p.sy * hit.away];
      hit.point = eye.target.map((t, k) => t + u * p.a.right[k] + v * p.a.up[k] + (eye.distance - hit.away) * p.a.back[k]);
    }
    clicked.forEach((tell) => tell(hit));
  });
  canvas.addEventListener('pointercancel', (e) => held.delete(e.pointerId));
  canvas.addEventListener('contextmenu', (e) => e.preventDefault());
  canvas.addEventListener('wheel', (e) => { e.preventDefault(); zoom(Math.exp(Math.max(-1, Math.min(1, e.deltaY * 0.0015)))); redraw(); }, { passive: false });
  canvas.addEventListener('dblclick', () => { eye = home(); redraw(); });
  canvas.addEventListener('keydown', (e) => {
    const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[e.key];
    if (step) { eye.azimuth += 0.1 * step[0]; eye.elevation = Math.min(Math.max(eye.elevation + 0.1 * step[1], -1.57), 1.57); }
    else if (e.key === '+' || e.key === '=') zoom(0.87);
    else if (e.key === '-') zoom(1.15);
    else if (e.key === 'Home') eye = home();
    else return;
    e.preventDefault();
    redraw();
  });
  const standard = { iso: [-0.95, 0.5], top: [-Math.PI / 2, 1.57], front: [-Math.PI / 2, 0], right: [0, 0] };
  figure.querySelectorAll('[data-view]').forEach((b) => b.addEventListener('click', () => {
    eye = home();
    [eye.azimuth, eye.elevation] = standard[b.dataset.view];
    redraw();
  }));
  const toggle = figure.querySelector('[data-toggle]');
  if (toggle) toggle.addEventListener('click', () => {
    colored = !colored;
    toggle.setAttribute('aria-pressed', colored);
    redraw();
  });
  // Several sets of colors on one mesh: a button each, and the ends of the legend
  const layers = data.layers || [], choices = [...figure.querySelectorAll('[data-layer]')];
  choices.forEach((b) => b.addEventListener('click', () => {
    const layer = layers[b.dataset.layer];
    if (!layer || !valueBuffer) return;
    gl.bindBuffer(gl.ARRAY_BUFFER, valueBuffer);
    gl.bufferData(gl.ARRAY_BUFFER, bytesOf(layer.shades), gl.STATIC_DRAW);
    figure.querySelector('[data-low]').textContent = layer.low;
    figure.querySelector('[data-high]').textContent = layer.high;
    choices.forEach((c) => c.setAttribute('aria-pressed', c === b));
    redraw();
  }));
  // Looks at a place along the normal of the surface there, a little from above
  const lookAt = (point, near) => {
    let best = Infinity, n = [0, 0, 1];
    for (let i = 0; i < vertices; i++) {
      const v = vertex(i), d = (v[0] - point[0]) ** 2 + (v[1] - point[1]) ** 2 + (v[2] - point[2]) ** 2;
      if (d < best) { best = d; n = [normals[3 * i], normals[3 * i + 1], normals[3 * i + 2]]; }
    }
    const flat = Math.hypot(n[0], n[1]);
    if (flat > 0.1 * Math.hypot(...n)) eye.azimuth = Math.atan2(n[1], n[0]) + 0.35;
    eye.elevation = Math.min(Math.max(Math.atan2(n[2], flat) * 0.75 + 0.2, -1.2), 1.2);
    eye.target = [...point];
    eye.distance = Math.min(eye.distance, (near || 1.6) * radius);
    redraw();
  };
  const choose = (id) => {
    const mark = marks.find((m) => m.id === id);
    marks.forEach((m) => m.button.classList.toggle('chosen', m === mark));
    if (mark) lookAt(mark.point);
    return Boolean(mark);
  };
  new ResizeObserver(redraw).observe(canvas);
  window.addEventListener('beforeprint', draw);
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', redraw);
  draw();
  note.textContent = '';
  figure.dataset.ready = 'yes';
  return {
    data, choose, setPath, lookAt,
    setRange(gouge, excess) { range = [gouge, excess]; redraw(); },
    onClick(tell) { clicked.push(tell); },
    frame(low, high) {
      const center = low.map((v, k) => (v + high[k]) / 2), reach = Math.max(Math.hypot(...low.map((v, k) => high[k] - v)) / 2, 0.12 * radius);
      eye.target = center;
      eye.distance = Math.min(Math.max(2.2 * reach / Math.sin(lens / 2), 0.3 * radius), 3 * radius);
      redraw();
    },
    state: () => ({ ...eye, range, colored, all: paths.all?.count || 0, chosen: paths.chosen?.count || 0, behind: marks.filter((m) => m.button.classList.contains('behind')).length }),
  };
})();
