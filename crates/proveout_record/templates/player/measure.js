// The distance of two places that are clicked, with its error: that of the meshes, once for each place.
const measureOf = (view, say, errorNow) => {
  'use strict';
  const button = view.figure.querySelector('[data-measure]');
  let on = false, first = null, result = null;
  const mm = (v) => `${v.toFixed(3)} mm`;
  // A cross at each place, as wide as a few points of the screen
  const cross = (p, reach) => [[1, 0, 0], [0, 1, 0], [0, 0, 1]].flatMap((d) => [...Vectors.along(p, d, -reach), ...Vectors.along(p, d, reach), 0]);
  const draw = (points) => {
    const reach = 6 * view.camera.perPoint();
    const segments = points.flatMap((p) => cross(p, reach));
    if (points.length === 2) segments.push(...points[0], ...points[1], 0);
    view.setPath('measured', segments.length ? new Float32Array(segments) : null);
  };
  const set = (to) => {
    on = to;
    first = null;
    if (button) button.setAttribute('aria-pressed', on);
    if (on) say('Distance: click the first place.');
    else { draw([]); result = null; }
  };
  if (button) button.addEventListener('click', () => set(!on));
  view.onClick((hit) => {
    if (!on) return false;
    if (!hit) { say('Nothing there: click a place on the part.'); return true; }
    const place = hit.point.map((v, k) => 'XYZ'[k] + ' ' + v.toFixed(3)).join(' ');
    if (!first) {
      first = hit.point;
      draw([first]);
      say(`From ${place}: click the second place.`);
      return true;
    }
    const way = Vectors.less(hit.point, first), length = Math.hypot(...way), error = 2 * errorNow();
    result = { from: first, to: hit.point, length, error };
    draw([first, hit.point]);
    say(`Distance ${mm(length)}, by axes ${way.map((v, k) => 'XYZ'[k] + ' ' + v.toFixed(3)).join(', ')}; within ${mm(error)} by the meshes of this page. One point of the screen is ${mm(view.camera.perPoint())}.`);
    first = null;
    return true;
  }, true);
  return { set, result: () => result };
};
