// Viewer of the cut part: orbit, pan, zoom; colored by deviation. Reads the mesh packed by encode.rs.
(() => {
  'use strict';
  const figure = document.getElementById('part-view');
  if (!figure) return;
  const canvas = figure.querySelector('canvas');
  const note = figure.querySelector('.view-note');
  const data = JSON.parse(document.getElementById('part-data').textContent);
  const bytesOf = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const gl = canvas.getContext('webgl2', { antialias: true, preserveDrawingBuffer: true, alpha: true });
  if (!gl) {
    note.textContent = 'This browser shows no WebGL 2 graphics. The same shape is in part.glb and deviation.glb.';
    return;
  }

  // Mesh
  const bytes = bytesOf(document.getElementById('part-mesh').textContent.trim());
  const view = new DataView(bytes.buffer);
  const vertices = view.getUint32(0, true), triangles = view.getUint32(4, true);
  const low = [8, 12, 16].map((o) => view.getFloat32(o, true)), size = [20, 24, 28].map((o) => view.getFloat32(o, true));
  let at = 32;
  const positions = new Uint16Array(bytes.buffer, at, 3 * vertices); at += 6 * vertices;
  const normals = new Int8Array(bytes.buffer, at, 3 * vertices); at += 3 * vertices;
  const shades = data.colored ? new Uint8Array(bytes.buffer, at, vertices) : null;
  if (shades) at += vertices;
  const indices = new Uint32Array(3 * triangles);
  for (let i = 0, last = 0; i < indices.length; i++) {
    let code = 0, factor = 1, byte;
    do { byte = bytes[at++]; code += (byte & 127) * factor; factor *= 128; } while (byte > 127);
    last += code % 2 ? -(code + 1) / 2 : code / 2;
    indices[i] = last;
  }

  // Program
  const compile = (kind, text) => { const s = gl.createShader(kind); gl.shaderSource(s, text); gl.compileShader(s); return s; };
  const program = gl.createProgram();
  gl.attachShader(program, compile(gl.VERTEX_SHADER, `#version 300 es
    in vec3 position; in vec3 normal; in float shade;
    uniform mat4 clip; uniform mat3 turn; uniform vec3 low, size;
    out vec3 n; out float s, known;
    void main() {
      gl_Position = clip * vec4(low + size * position, 1.0); n = turn * normal;
      known = shade < 0.999 ? 1.0 : 0.0; s = shade < 0.999 ? shade * 255.0 / 254.0 : 0.5;
    }`));
  gl.attachShader(program, compile(gl.FRAGMENT_SHADER, `#version 300 es
    precision highp float;
    in vec3 n; in float s, known; uniform sampler2D map; uniform vec3 plain; uniform bool colored;
    out vec4 color;
    void main() {
      vec3 base = colored && known > 0.99 ? texture(map, vec2(s * 255.0 / 256.0 + 0.5 / 256.0, 0.5)).rgb : plain;
      vec3 d = normalize(n);
      if (!gl_FrontFacing) { d = -d; base *= 0.6; }
      float head = max(d.z, 0.0);
      float key = max(dot(d, normalize(vec3(-0.4, 0.7, 0.6))), 0.0);
      float shine = pow(max(dot(d, normalize(vec3(-0.2, 0.35, 0.9))), 0.0), 40.0);
      color = vec4(base * (0.34 + 0.38 * head + 0.34 * key) + 0.10 * shine, 1.0);
    }`));
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) { note.textContent = 'The 3D view could not start.'; return; }
  gl.useProgram(program);
  const feed = (name, array, width, type) => {
    const slot = gl.getAttribLocation(program, name);
    if (slot < 0) return null;
    const buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, array, gl.STATIC_DRAW);
    gl.enableVertexAttribArray(slot);
    gl.vertexAttribPointer(slot, width, type, true, 0, 0);
    return buffer;
  };
  feed('position', positions, 3, gl.UNSIGNED_SHORT);
  feed('normal', normals, 3, gl.BYTE);
  const shadeBuffer = shades ? feed('shade', shades, 1, gl.UNSIGNED_BYTE) : null;
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indices, gl.STATIC_DRAW);
  gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB, 256, 1, 0, gl.RGB, gl.UNSIGNED_BYTE, bytesOf(data.map));
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
  const slot = (name) => gl.getUniformLocation(program, name);
  gl.uniform3fv(slot('low'), low);
  gl.uniform3fv(slot('size'), size);
  gl.uniform3fv(slot('plain'), data.plain.map((c) => c / 255));
  gl.enable(gl.DEPTH_TEST);

  // Camera: looks at `target` from `distance`; azimuth about Z, elevation above the XY plane, radian
  const radius = Math.max(Math.hypot(...size) / 2, 1e-3), lens = 0.5;
  const focus = data.focus || { target: low.map((v, k) => v + size[k] / 2), radius };
  const home = () => ({ target: [...focus.target], azimuth: -0.95, elevation: 0.5, distance: 1.06 * focus.radius / Math.sin(lens / 2) });
  let eye = home(), colored = data.colored, waiting = false;
  const axes = () => {
    const [sa, ca, se, ce] = [Math.sin(eye.azimuth), Math.cos(eye.azimuth), Math.sin(eye.elevation), Math.cos(eye.elevation)];
    return { right: [-sa, ca, 0], up: [-se * ca, -se * sa, ce], back: [ce * ca, ce * sa, se] };
  };
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const project = (p, { right, up, back }) => {
    const d = p.map((v, k) => v - eye.target[k]);
    return [dot(d, right), dot(d, up), dot(d, back) - eye.distance];
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

  function draw() {
    waiting = false;
    const width = canvas.clientWidth, height = canvas.clientHeight, ratio = Math.min(window.devicePixelRatio || 1, 2);
    if (!width || !height) return;
    if (canvas.width !== Math.round(width * ratio)) canvas.width = Math.round(width * ratio);
    if (canvas.height !== Math.round(height * ratio)) canvas.height = Math.round(height * ratio);
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const a = axes(), f = 1 / Math.tan(lens / 2), g = width < height ? f * width / height : f;
    const sx = g * height / width, sy = g;
    const near = Math.max(eye.distance - 2.5 * radius, 0.01 * radius), far = eye.distance + 4 * radius;
    const zs = (far + near) / (near - far), zt = 2 * far * near / (near - far);
    const shift = [a.right, a.up, a.back].map((v) => -dot(v, eye.target));
    shift[2] -= eye.distance;
    const clip = [];
    for (let k = 0; k < 3; k++) clip.push(sx * a.right[k], sy * a.up[k], zs * a.back[k], -a.back[k]);
    clip.push(sx * shift[0], sy * shift[1], zs * shift[2] + zt, -shift[2]);
    gl.uniformMatrix4fv(slot('clip'), false, clip);
    gl.uniformMatrix3fv(slot('turn'), false, [0, 1, 2].flatMap((k) => [a.right[k], a.up[k], a.back[k]]));
    gl.uniform1i(slot('colored'), colored ? 1 : 0);
    gl.drawElements(gl.TRIANGLES, indices.length, gl.UNSIGNED_INT, 0);
    for (const mark of marks) {
      const [x, y, z] = project(mark.point, a);
      const seen = z < 0 && Math.abs(sx * x) < -z && Math.abs(sy * y) < -z;
      mark.button.style.display = seen ? '' : 'none';
      if (seen) mark.button.style.transform = `translate(${(0.5 - 0.5 * sx * x / z) * width}px, ${(0.5 + 0.5 * sy * y / z) * height}px)`;
    }
    const triad = figure.querySelector('.triad');
    [[1, 0, 0], [0, 1, 0], [0, 0, 1]].forEach((axis, k) => {
      const x = 32 + 22 * dot(axis, a.right), y = 32 - 22 * dot(axis, a.up), line = triad.children[2 * k], name = triad.children[2 * k + 1];
      line.setAttribute('x2', x); line.setAttribute('y2', y);
      name.setAttribute('x', 32 + 1.3 * (x - 32)); name.setAttribute('y', 32 + 1.3 * (y - 32));
    });
  }
  const redraw = () => { if (!waiting) { waiting = true; requestAnimationFrame(draw); } };

  // Pointer: one turns, two (or right button, or Shift) move and zoom
  const held = new Map();
  const pan = (dx, dy) => {
    const a = axes(), s = 2 * eye.distance * Math.tan(lens / 2) / canvas.clientHeight;
    eye.target = eye.target.map((v, k) => v - s * dx * a.right[k] + s * dy * a.up[k]);
  };
  const zoom = (factor) => { eye.distance = Math.min(Math.max(eye.distance * factor, 0.05 * radius), 40 * radius); };
  canvas.addEventListener('pointerdown', (e) => { canvas.setPointerCapture(e.pointerId); held.set(e.pointerId, [e.clientX, e.clientY]); });
  canvas.addEventListener('pointermove', (e) => {
    const last = held.get(e.pointerId);
    if (!last) return;
    const dx = e.clientX - last[0], dy = e.clientY - last[1];
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
  for (const name of ['pointerup', 'pointercancel']) canvas.addEventListener(name, (e) => held.delete(e.pointerId));
  canvas.addEventListener('contextmenu', (e) => e.preventDefault());
  canvas.addEventListener('wheel', (e) => { e.preventDefault(); zoom(Math.exp(Math.max(-1, Math.min(1, e.deltaY * 0.0015)))); redraw(); }, { passive: false });
  canvas.addEventListener('dblclick', () => { eye = home(); redraw(); });
  canvas.addEventListener('keydown', (e) => {
    const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[e.key];
    if (step) { eye.azimuth += 0.1 * step[0]; eye.elevation = Math.min(Math.max(eye.elevation + 0.1 * step[1], -1.57), 1.57); }
    else if (e.key === '+' || e.key === '=') zoom(0.87);
    else if (e.key === '-') zoom(1.15);
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
    if (!layer || !shadeBuffer) return;
    gl.bindBuffer(gl.ARRAY_BUFFER, shadeBuffer);
    gl.bufferData(gl.ARRAY_BUFFER, bytesOf(layer.shades), gl.STATIC_DRAW);
    figure.querySelector('[data-low]').textContent = layer.low;
    figure.querySelector('[data-high]').textContent = layer.high;
    choices.forEach((c) => c.setAttribute('aria-pressed', c === b));
    redraw();
  }));
  document.querySelectorAll('[data-mark]').forEach((link) => link.addEventListener('click', () => {
    const mark = marks.find((m) => m.id === link.dataset.mark);
    if (!mark) return;
    eye.target = [...mark.point];
    eye.distance = Math.min(eye.distance, 1.6 * radius);
    marks.forEach((m) => m.button.classList.toggle('chosen', m === mark));
    redraw();
  }));
  new ResizeObserver(redraw).observe(canvas);
  window.addEventListener('beforeprint', draw);
  draw();
  note.textContent = '';
})();
