// The camera: looks at `target` from `distance`; azimuth about Z, elevation above the XY plane, radian. Pointer, wheel and keys move it.
const cameraOf = (canvas, focus, radius, redraw) => {
  'use strict';
  const lens = 0.5, { dot } = Vectors;
  let placed = (point) => [...point];
  const home = () => ({ target: placed(focus.target), azimuth: -0.95, elevation: 0.5, distance: 1.06 * focus.radius / Math.sin(lens / 2) });
  let eye = home(), reach = radius;
  const axes = () => {
    const [sa, ca, se, ce] = [Math.sin(eye.azimuth), Math.cos(eye.azimuth), Math.sin(eye.elevation), Math.cos(eye.elevation)];
    return { right: [-sa, ca, 0], up: [-se * ca, -se * sa, ce], back: [ce * ca, ce * sa, se] };
  };
  // Scales of the projection, and the matrix
  const projection = () => {
    const width = canvas.clientWidth, height = canvas.clientHeight, a = axes(), f = 1 / Math.tan(lens / 2), g = width < height ? f * width / height : f;
    const sx = g * height / width, sy = g;
    const near = Math.max(eye.distance - 2.5 * reach, 0.01 * radius), far = eye.distance + 4 * reach;
    const zs = (far + near) / (near - far), zt = 2 * far * near / (near - far);
    const shift = [a.right, a.up, a.back].map((v) => -dot(v, eye.target));
    shift[2] -= eye.distance;
    const clip = [];
    for (let k = 0; k < 3; k++) clip.push(sx * a.right[k], sy * a.up[k], zs * a.back[k], -a.back[k]);
    clip.push(sx * shift[0], sy * shift[1], zs * shift[2] + zt, -shift[2]);
    return { a, sx, sy, clip };
  };
  // Where a point is in the window (CSS points), and how far away; `inside` is false out of sight
  const onScreen = (p, point) => {
    const d = point.map((v, k) => v - eye.target[k]);
    const [x, y, z] = [dot(d, p.a.right), dot(d, p.a.up), dot(d, p.a.back) - eye.distance];
    const inside = z < 0 && Math.abs(p.sx * x) < -z && Math.abs(p.sy * y) < -z;
    return { inside, left: (0.5 - 0.5 * p.sx * x / z) * canvas.clientWidth, top: (0.5 + 0.5 * p.sy * y / z) * canvas.clientHeight, away: -z };
  };
  // The point so far away under a place of the window
  const pointAt = (p, x, y, away) => {
    const [u, v] = [(2 * x / canvas.clientWidth - 1) / p.sx * away, (1 - 2 * y / canvas.clientHeight) / p.sy * away];
    return eye.target.map((t, k) => t + u * p.a.right[k] + v * p.a.up[k] + (eye.distance - away) * p.a.back[k]);
  };

  // Pointer: one turns, two (or right button, or Shift) move and zoom; a click without a way asks what is there
  const held = new Map(), clicked = [];
  let way = 0, most = 0;
  const perPoint = () => 2 * eye.distance * Math.tan(lens / 2) / canvas.clientHeight;
  const pan = (dx, dy) => {
    const a = axes(), s = perPoint();
    eye.target = eye.target.map((v, k) => v - s * dx * a.right[k] + s * dy * a.up[k]);
  };
  const zoom = (factor) => { eye.distance = Math.min(Math.max(eye.distance * factor, 0.05 * radius), 40 * Math.max(radius, reach / 4)); };
  const tilt = (by) => { eye.elevation = Math.min(Math.max(eye.elevation + by, -1.57), 1.57); };
  canvas.addEventListener('pointerdown', (e) => {
    canvas.setPointerCapture(e.pointerId);
    if (!held.size) { way = 0; most = 0; }
    held.set(e.pointerId, [e.clientX, e.clientY]);
    most = Math.max(most, held.size);
  });
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
      tilt(0.008 * dy);
    }
    held.set(e.pointerId, [e.clientX, e.clientY]);
    redraw();
  });
  canvas.addEventListener('pointerup', (e) => {
    held.delete(e.pointerId);
    if (way > 4 || most > 1 || e.button !== 0) return;
    const box = canvas.getBoundingClientRect();
    clicked.forEach((tell) => tell(e.clientX - box.left, e.clientY - box.top));
  });
  canvas.addEventListener('pointercancel', (e) => held.delete(e.pointerId));
  canvas.addEventListener('contextmenu', (e) => e.preventDefault());
  canvas.addEventListener('wheel', (e) => { e.preventDefault(); zoom(Math.exp(Math.max(-1, Math.min(1, e.deltaY * 0.0015)))); redraw(); }, { passive: false });
  canvas.addEventListener('dblclick', () => { eye = home(); redraw(); });
  canvas.addEventListener('keydown', (e) => {
    const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[e.key];
    if (step) { eye.azimuth += 0.1 * step[0]; tilt(0.1 * step[1]); }
    else if (e.key === '+' || e.key === '=') zoom(0.87);
    else if (e.key === '-') zoom(1.15);
    else if (e.key === 'Home') eye = home();
    else return;
    e.preventDefault();
    redraw();
  });
  return {
    projection, onScreen, pointAt, perPoint,
    get eye() { return eye; },
    // From one of the standard directions
    look(azimuth, elevation) { eye = { ...home(), azimuth, elevation }; redraw(); },
    // Where a point of the workpiece is in the frame that is drawn
    setPlace(to) { placed = to; },
    // How far bodies reach that are in sight, mm
    setReach(to) { reach = Math.max(radius, to); },
    frame(center, around) {
      eye.target = center;
      eye.distance = Math.min(Math.max(2.2 * around / Math.sin(lens / 2), 0.3 * radius), 3 * radius);
      redraw();
    },
    onClick(tell) { clicked.push(tell); },
  };
};
