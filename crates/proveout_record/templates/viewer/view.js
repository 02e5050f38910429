// The part in three dimensions: colors by deviation, markers that hide behind walls, what was clicked; what else moves is put beside it.
const partView = (async () => {
  'use strict';
  const figure = document.getElementById('part-view');
  if (!figure) return null;
  const canvas = figure.querySelector('canvas');
  const note = figure.querySelector('.view-note');
  const data = JSON.parse(document.getElementById('part-data').textContent);
  const gl = canvas.getContext('webgl2', { antialias: true, preserveDrawingBuffer: true, alpha: true, stencil: true });
  if (!gl) {
    note.textContent = 'This browser shows no WebGL 2 graphics. The same shape is in part.glb and deviation.glb.';
    return null;
  }
  const kit = graphicsOf(gl);
  if (!kit.ok) { note.textContent = 'The 3D view could not start.'; return null; }
  const { shown, picked, drawn, face, facePicked } = kit.programs;
  const mesh = meshAt(await inflated('part-mesh'), 0, { values: data.values, shades: !data.values && data.colored, blocks: data.blocks });
  const body = kit.mesh(mesh), box = { low: mesh.low, size: mesh.size };
  kit.colorTable(0, bytesOf(data.map), true);
  const setTable = kit.colorTable(1, new Uint8Array(768), false);
  const vertex = (i) => [0, 1, 2].map((k) => mesh.low[k] + mesh.size[k] * mesh.positions[3 * i + k] / 65535);
  const { dot } = Vectors;
  const radius = Math.max(Math.hypot(...mesh.size) / 2, 1e-3);
  const camera = cameraOf(canvas, data.focus || { target: mesh.low.map((v, k) => v + mesh.size[k] / 2), radius }, radius, redraw);
  const section = sectionOf(figure, box, redraw, (k) => dot(camera.projection().a.back, [scene.place[k], scene.place[4 + k], scene.place[8 + k]]));

  // What is shown: meshes of the part (none: the part as judged), bodies with their poses, where the workpiece is, blocks whose surface is marked
  const scene = { parts: null, bodies: [], place: Poses.none, marked: [1, 0], moving: false, tagged: false };
  camera.setPlace((point) => Poses.point(scene.place, point));
  let colored = Boolean(body.mode), range = data.scales ? data.scales.map((s) => s[0]) : [1, 1], waiting = false;
  const parts = () => scene.parts || [body];
  const paths = { all: null, chosen: null, measured: null };
  const setPath = (which, segments) => {
    paths[which]?.free();
    paths[which] = segments && segments.length ? kit.path(segments) : null;
    redraw();
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

  const whole = [0, 0, 0, 1];
  const drawMesh = (program, p, one, pose, plane) => {
    gl.uniformMatrix4fv(program.at('clip'), false, Poses.under(p.clip, pose));
    gl.uniform3fv(program.at('low'), one.low);
    gl.uniform3fv(program.at('size'), one.size);
    gl.uniform4fv(program.at('plane'), plane);
    if (program === shown) {
      const turned = [0, 1, 2].flatMap((c) => { const axis = [pose[c], pose[4 + c], pose[8 + c]]; return [dot(p.a.right, axis), dot(p.a.up, axis), dot(p.a.back, axis)]; });
      gl.uniformMatrix3fv(shown.at('turn'), false, turned);
    }
    gl.bindVertexArray(one.array);
    gl.drawElements(gl.TRIANGLES, one.count, gl.UNSIGNED_INT, 0);
  };
  // The face of a section: where more of the kept faces look away from the eye than to it, the plane is in the material
  const drawFace = (program, flat, p) => {
    gl.enable(gl.STENCIL_TEST);
    gl.disable(gl.DEPTH_TEST);
    gl.depthMask(false);
    gl.colorMask(false, false, false, false);
    gl.stencilFunc(gl.ALWAYS, 0, 255);
    gl.stencilOpSeparate(gl.BACK, gl.KEEP, gl.KEEP, gl.INCR_WRAP);
    gl.stencilOpSeparate(gl.FRONT, gl.KEEP, gl.KEEP, gl.DECR_WRAP);
    for (const one of parts()) drawMesh(program, p, one, scene.place, section.plane());
    gl.colorMask(true, true, true, true);
    gl.depthMask(true);
    gl.enable(gl.DEPTH_TEST);
    gl.stencilFunc(gl.NOTEQUAL, 0, 255);
    gl.stencilOp(gl.KEEP, gl.KEEP, gl.KEEP);
    gl.useProgram(flat.program);
    gl.uniformMatrix4fv(flat.at('clip'), false, Poses.under(p.clip, scene.place));
    if (flat === face) gl.uniform3fv(face.at('plain'), data.plain.map((c) => c / 255));
    kit.square.draw(section.corners());
    gl.disable(gl.STENCIL_TEST);
  };

  // What lies under each point of a small picture: block, distance, deviation
  const small = { frame: gl.createFramebuffer(), width: 0, height: 0, found: null };
  const look = (p) => {
    const width = Math.max(1, Math.round(canvas.clientWidth / 2)), height = Math.max(1, Math.round(canvas.clientHeight / 2));
    gl.bindFramebuffer(gl.FRAMEBUFFER, small.frame);
    if (small.width !== width || small.height !== height) {
      for (const [format, point] of [[gl.RGBA32UI, gl.COLOR_ATTACHMENT0], [gl.DEPTH24_STENCIL8, gl.DEPTH_STENCIL_ATTACHMENT]]) {
        const store = gl.createRenderbuffer();
        gl.bindRenderbuffer(gl.RENDERBUFFER, store);
        gl.renderbufferStorage(gl.RENDERBUFFER, format, width, height);
        gl.framebufferRenderbuffer(gl.FRAMEBUFFER, point, gl.RENDERBUFFER, store);
      }
      Object.assign(small, { width, height, found: new Uint32Array(4 * width * height) });
    }
    gl.viewport(0, 0, width, height);
    gl.clearBufferuiv(gl.COLOR, 0, [0, 0, 0, 0]);
    gl.clearBufferfi(gl.DEPTH_STENCIL, 0, 1, 0);
    gl.useProgram(picked.program);
    gl.uniform1ui(picked.at('kind'), 1);
    for (const one of parts()) drawMesh(picked, p, one, scene.place, section.plane());
    if (section.on()) drawFace(picked, facePicked, p);
    gl.readPixels(0, 0, width, height, gl.RGBA_INTEGER, gl.UNSIGNED_INT, small.found);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  };
  const float = new DataView(new ArrayBuffer(4));
  const asFloat = (bits) => { float.setUint32(0, bits); return float.getFloat32(0); };
  // At a place of the canvas, CSS points from the upper left; `x` and `y` are those of the point that was looked at
  const under = (x, y) => {
    const i = Math.floor(x * small.width / canvas.clientWidth), j = small.height - 1 - Math.floor(y * small.height / canvas.clientHeight);
    if (i < 0 || j < 0 || i >= small.width || j >= small.height) return null;
    const [block, away, value, kind] = small.found.subarray(4 * (j * small.width + i), 4 * (j * small.width + i) + 4);
    if (!kind) return null;
    const deviation = asFloat(value), measured = data.values && !scene.parts && kind === 1 && deviation < 6e4;
    return {
      block, face: kind === 2, away: asFloat(away), value: measured ? deviation : null,
      x: (i + 0.5) * canvas.clientWidth / small.width, y: (small.height - j - 0.5) * canvas.clientHeight / small.height,
    };
  };

  const style = getComputedStyle(document.documentElement);
  const ink = (name) => { const c = style.getPropertyValue(name).trim().slice(1); return [0, 2, 4].map((k) => parseInt(c.slice(k, k + 2), 16) / 255); };
  const drawParts = (p) => {
    gl.useProgram(shown.program);
    gl.uniform1i(shown.at('map'), 0);
    gl.uniform1i(shown.at('tags'), 1);
    gl.uniform3fv(shown.at('plain'), data.plain.map((c) => c / 255));
    gl.uniform2fv(shown.at('range'), range);
    gl.uniform2uiv(shown.at('marked'), scene.marked);
    gl.uniform1f(shown.at('alpha'), 1);
    for (const one of parts()) {
      gl.uniform1i(shown.at('mode'), scene.tagged ? 3 : colored ? one.mode : 0);
      drawMesh(shown, p, one, scene.place, section.plane());
    }
    if (section.on()) drawFace(shown, face, p);
  };
  const drawBodies = (p, clear) => {
    gl.useProgram(shown.program);
    gl.uniform1i(shown.at('mode'), 0);
    gl.uniform2uiv(shown.at('marked'), [1, 0]);
    for (const one of scene.bodies) {
      if (one.alpha < 1 !== clear) continue;
      gl.uniform3fv(shown.at('plain'), one.color.map((c) => c / 255));
      gl.uniform1f(shown.at('alpha'), one.alpha);
      drawMesh(shown, p, one.mesh, one.pose, whole);
    }
  };
  const drawPaths = (p, ratio) => {
    gl.useProgram(drawn.program);
    gl.uniformMatrix4fv(drawn.at('clip'), false, Poses.under(p.clip, scene.place));
    gl.uniform2f(drawn.at('canvas'), canvas.width, canvas.height);
    for (const [path, wide, feed, rapid] of [[paths.all, 0.8, '--cut', '--rapid'], [paths.chosen, 2.6, '--fail', '--rapid'], [paths.measured, 2.2, '--ink', '--ink']]) {
      if (!path) continue;
      gl.bindVertexArray(path.array);
      gl.uniform1f(drawn.at('width'), wide * ratio);
      gl.uniform3fv(drawn.at('feed'), ink(feed));
      gl.uniform3fv(drawn.at('rapid'), ink(rapid));
      // Where the part hides it, it shows through.
      for (const [test, alpha] of [[gl.GREATER, 0.22], [gl.LEQUAL, 0.95]]) {
        gl.depthFunc(test);
        gl.uniform1f(drawn.at('alpha'), alpha);
        gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, path.count);
      }
    }
    gl.depthFunc(gl.LESS);
  };
  const toScreen = (p) => (point) => camera.onScreen(p, Poses.point(scene.place, point));
  const arrangeMarks = (p) => {
    const put = toScreen(p);
    for (const mark of marks) {
      const at = put(mark.point), wall = at.inside && !scene.moving && under(at.left, at.top);
      // A place in the material belongs to the surface over it.
      const hidden = wall && wall.away < at.away - 0.03 * radius, seen = at.inside && !scene.moving;
      mark.button.style.display = seen ? '' : 'none';
      mark.button.classList.toggle('behind', Boolean(hidden));
      if (seen) mark.button.style.transform = `translate(${at.left}px, ${at.top}px)`;
    }
    section.arrange(put);
    const triad = figure.querySelector('.triad');
    [0, 1, 2].forEach((k) => {
      const axis = [scene.place[k], scene.place[4 + k], scene.place[8 + k]];
      const x = 32 + 22 * dot(axis, p.a.right), y = 32 - 22 * dot(axis, p.a.up), line = triad.children[2 * k], name = triad.children[2 * k + 1];
      line.setAttribute('x2', x); line.setAttribute('y2', y);
      name.setAttribute('x', 32 + 1.3 * (x - 32)); name.setAttribute('y', 32 + 1.3 * (y - 32));
    });
  };
  const resize = () => {
    const width = canvas.clientWidth, height = canvas.clientHeight, ratio = Math.min(window.devicePixelRatio || 1, 2);
    if (!width || !height) return 0;
    if (canvas.width !== Math.round(width * ratio)) canvas.width = Math.round(width * ratio);
    if (canvas.height !== Math.round(height * ratio)) canvas.height = Math.round(height * ratio);
    return ratio;
  };
  function draw() {
    waiting = false;
    const ratio = resize();
    if (!ratio) return;
    const p = camera.projection();
    if (marks.length && !scene.moving) look(p);
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT | gl.STENCIL_BUFFER_BIT);
    drawParts(p);
    drawBodies(p, false);
    gl.enable(gl.BLEND);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthMask(false);
    drawPaths(p, ratio);
    // Of a clear body only what looks to the eye.
    gl.enable(gl.CULL_FACE);
    drawBodies(p, true);
    gl.disable(gl.CULL_FACE);
    gl.depthMask(true);
    gl.disable(gl.BLEND);
    arrangeMarks(p);
  }
  function redraw() { if (!waiting) { waiting = true; requestAnimationFrame(draw); } }

  const clicked = [];
  camera.onClick((x, y) => {
    const p = camera.projection();
    look(p);
    redraw();
    const hit = under(x, y);
    if (hit) {
      hit.point = Poses.point(Poses.inverse(scene.place), camera.pointAt(p, hit.x, hit.y, hit.away));
      const plane = hit.face && section.place();
      if (plane) hit.point['XYZ'.indexOf(plane.axis)] = plane.at;
    }
    // The first that takes it is the last that hears of it.
    clicked.some((tell) => tell(hit) === true);
  });
  const standard = { iso: [-0.95, 0.5], top: [-Math.PI / 2, 1.57], front: [-Math.PI / 2, 0], right: [0, 0] };
  figure.querySelectorAll('[data-view]').forEach((b) => b.addEventListener('click', () => camera.look(...standard[b.dataset.view])));
  const toggle = figure.querySelector('[data-toggle]');
  const setColored = (on) => { colored = on; if (toggle) toggle.setAttribute('aria-pressed', on); redraw(); };
  if (toggle) toggle.addEventListener('click', () => setColored(!colored));
  // Several sets of colors on one mesh: a button each, and the ends of the legend
  const layers = data.layers || [], choices = [...figure.querySelectorAll('[data-layer]')];
  choices.forEach((b) => b.addEventListener('click', () => {
    const layer = layers[b.dataset.layer];
    if (!layer) return;
    body.setColors(bytesOf(layer.shades));
    figure.querySelector('[data-low]').textContent = layer.low;
    figure.querySelector('[data-high]').textContent = layer.high;
    choices.forEach((c) => c.setAttribute('aria-pressed', c === b));
    redraw();
  }));
  // Looks at a place along the normal of the surface there, a little from above
  const lookAt = (point, near) => {
    let best = Infinity, n = [0, 0, 1];
    for (let i = 0; i < mesh.vertices; i++) {
      const v = vertex(i), d = (v[0] - point[0]) ** 2 + (v[1] - point[1]) ** 2 + (v[2] - point[2]) ** 2;
      if (d < best) { best = d; n = [mesh.normals[3 * i], mesh.normals[3 * i + 1], mesh.normals[3 * i + 2]]; }
    }
    n = Poses.direction(scene.place, n);
    const eye = camera.eye, flat = Math.hypot(n[0], n[1]);
    if (flat > 0.1 * Math.hypot(...n)) eye.azimuth = Math.atan2(n[1], n[0]) + 0.35;
    eye.elevation = Math.min(Math.max(Math.atan2(n[2], flat) * 0.75 + 0.2, -1.2), 1.2);
    eye.target = Poses.point(scene.place, point);
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
    data, figure, canvas, kit, body, box, camera, choose, setPath, lookAt, setTable, setColored,
    // Changes what is shown
    show(change) { Object.assign(scene, change); redraw(); },
    scene: () => scene,
    setRange(gouge, excess) { range = [gouge, excess]; redraw(); },
    // Calls for each click, with `first` before all others; one that returns true ends the calls
    onClick(tell, first) { if (first) clicked.unshift(tell); else clicked.push(tell); },
    frame(low, high) {
      const center = low.map((v, k) => (v + high[k]) / 2), around = Math.max(Math.hypot(...low.map((v, k) => high[k] - v)) / 2, 0.35 * radius);
      camera.frame(Poses.point(scene.place, center), around);
    },
    // Draws at once; for measuring how long it takes
    drawNow() { draw(); const one = new Uint8Array(4); gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, one); return one; },
    state: () => ({
      ...camera.eye, range, colored, section: section.place(), tagged: scene.tagged, bodies: scene.bodies.length, parts: parts().length,
      triangles: parts().reduce((sum, one) => sum + one.count / 3, 0),
      all: paths.all?.count || 0, chosen: paths.chosen?.count || 0, measured: paths.measured?.count || 0,
      behind: marks.filter((m) => m.button.classList.contains('behind')).length,
    }),
  };
})();
