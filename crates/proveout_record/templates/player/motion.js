// The run over time: blocks one after the other, joints, feed and loads between knots. Reads what player/steps.rs and knots.rs pack.
const motionOf = (bytes, joints) => {
  'use strict';
  const head = new DataView(bytes.buffer, bytes.byteOffset), TIME = 1e-4;
  const column = (at, count, scale) => {
    const values = new Float64Array(count), next = numbersAt(bytes, at, count, values);
    if (scale !== 1) for (let i = 0; i < count; i++) values[i] *= scale;
    return [values, next];
  };
  const count = head.getUint32(0, true), steps = { count };
  let at = 4;
  for (const [name, scale] of [['block', 1], ['line', 1], ['end', TIME], ['tool', 1], ['feed', 1], ['length', 0.01], ['volume', 0.1]]) [steps[name], at] = column(at, count, scale);
  // A series: times, and one list of values a signal
  const series = (signals, step) => {
    const knots = head.getUint32(at, true), out = { times: null, values: [] };
    [out.times, at] = column(at + 4, knots, TIME);
    for (let k = 0; k < signals; k++) [out.values[k], at] = column(at, knots, step);
    return out;
  };
  return { steps, series: (signals, step) => series(signals, step) };
};
// How many of rising numbers are at most as large
const countUpTo = (list, value) => {
  let low = 0, high = list.length;
  while (low < high) {
    const middle = low + high >> 1;
    if (list[middle] <= value) low = middle + 1; else high = middle;
  }
  return low;
};
// Values of all signals of a series at a time
const valuesAt = (series, time) => {
  const n = countUpTo(series.times, time), last = series.times.length - 1;
  if (last < 0) return series.values.map(() => 0);
  if (n === 0) return series.values.map((v) => v[0]);
  if (n > last) return series.values.map((v) => v[last]);
  const part = (time - series.times[n - 1]) / (series.times[n] - series.times[n - 1]);
  return series.values.map((v) => v[n - 1] + (v[n] - v[n - 1]) * part);
};
// All of it with its data; none where nothing moves
const runData = (async () => {
  'use strict';
  const element = document.getElementById('player-data');
  if (!element) return null;
  const data = JSON.parse(element.textContent), joints = data.kinematics.joints.length;
  const packed = motionOf(await inflated('player-motion'), joints), { steps } = packed;
  const joint = packed.series(joints, data.steps.joint), feed = packed.series(1, data.steps.feed), load = packed.series(joints, data.steps.load);
  // Number of the step that a block (plus one, as meshes name it) is in; -1 for the raw skin
  const stepOf = (tag) => (tag ? countUpTo(steps.block, tag - 1) - 1 : -1);
  return {
    data, steps, joint, feed, load, stepOf,
    lineOf: (tag) => { const k = stepOf(tag); return k < 0 ? 0 : steps.line[k]; },
    toolOf: (k) => { const code = steps.tool[k] >> 1; return code ? code - 1 : null; },
    begin: (k) => (k > 0 ? steps.end[k - 1] : 0),
    rapid: (k) => steps.tool[k] % 2 === 1,
  };
})();
