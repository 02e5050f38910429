// A plane that cuts the part: across X, Y or Z of the workpiece, moved by a slider or by its handle on the picture. `towards` says
// how far an axis looks to the eye: what lies before the plane is cut away.
const sectionOf = (figure, box, redraw, towards) => {
  'use strict';
  const tools = figure.querySelector('.section-tools');
  const state = { on: false, axis: 0, at: 0.5, side: 1 };
  const normal = () => [0, 1, 2].map((k) => (k === state.axis ? state.side : 0));
  const place = () => box.low[state.axis] + state.at * box.size[state.axis];
  // Numbers of the shader: what has a positive distance is cut away. Without a section nothing has.
  const plane = () => (state.on ? [...normal(), state.side * place()] : [0, 0, 0, 1]);
  const middle = () => box.low.map((v, k) => (k === state.axis ? place() : v + box.size[k] / 2));
  const corners = () => {
    const [u, v] = [0, 1, 2].filter((k) => k !== state.axis), out = [];
    for (const [a, b] of [[-0.1, -0.1], [1.1, -0.1], [-0.1, 1.1], [1.1, 1.1]]) {
      const p = middle();
      p[u] = box.low[u] + a * box.size[u];
      p[v] = box.low[v] + b * box.size[v];
      out.push(...p);
    }
    return out;
  };
  const none = { plane, on: () => false, place: () => null, corners, arrange() {} };
  if (!tools) return none;
  const handle = figure.querySelector('.section-handle'), slider = tools.querySelector('[data-section-at]');
  const toggle = figure.querySelector('[data-section]'), axis = tools.querySelector('[data-section-axis]'), words = tools.querySelector('output');
  const show = () => {
    toggle.setAttribute('aria-pressed', state.on);
    tools.hidden = handle.hidden = !state.on;
    slider.value = Math.round(1000 * state.at);
    words.textContent = `${'XYZ'[state.axis]} = ${place().toFixed(2)} mm`;
    redraw();
  };
  const open = () => { state.side = towards(state.axis) < 0 ? -1 : 1; };
  toggle.addEventListener('click', () => { state.on = !state.on; open(); show(); });
  axis.addEventListener('change', () => { state.axis = Number(axis.value); open(); show(); });
  slider.addEventListener('input', () => { state.at = Number(slider.value) / 1000; show(); });
  tools.querySelector('[data-section-turn]').addEventListener('click', () => { state.side = -state.side; show(); });
  // The handle moves along the normal as far as the pointer goes in its direction on the screen.
  let from = null;
  handle.addEventListener('pointerdown', (e) => { handle.setPointerCapture(e.pointerId); from = { x: e.clientX, y: e.clientY, at: state.at }; e.preventDefault(); });
  handle.addEventListener('pointermove', (e) => {
    if (!from) return;
    const { x, y } = handle.way, length2 = x * x + y * y;
    if (length2 < 1) return;
    const moved = ((e.clientX - from.x) * x + (e.clientY - from.y) * y) / length2;
    state.at = Math.min(Math.max(from.at + moved, 0), 1);
    show();
  });
  ['pointerup', 'pointercancel'].forEach((name) => handle.addEventListener(name, () => { from = null; }));
  handle.addEventListener('keydown', (e) => {
    const step = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[e.key];
    if (!step) return;
    e.preventDefault();
    state.at = Math.min(Math.max(state.at + 0.01 * step, 0), 1);
    show();
  });
  return {
    plane, corners,
    on: () => state.on,
    place: () => (state.on ? { axis: 'XYZ'[state.axis], at: place(), side: state.side } : null),
    // Puts the handle where the middle of the plane is; `toScreen` takes a point of the workpiece
    arrange(toScreen) {
      if (!state.on) return;
      const low = middle(), high = middle();
      low[state.axis] = box.low[state.axis];
      high[state.axis] = box.low[state.axis] + box.size[state.axis];
      const [a, b, here] = [low, high, middle()].map(toScreen);
      handle.way = { x: b.left - a.left, y: b.top - a.top };
      handle.style.display = here.inside ? '' : 'none';
      if (here.inside) handle.style.transform = `translate(${here.left}px, ${here.top}px)`;
    },
  };
};
