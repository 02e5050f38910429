// Bodies of the machine, fixtures, tools and parts that came off, where they are at a moment. Reads what player/bodies.rs packs.
const bodiesOf = (view, run, bytes) => {
  'use strict';
  const { data } = run, meshes = [];
  for (let k = 0, at = 0; k < data.meshes; k++) {
    const read = meshAt(bytes, at);
    at = read.next;
    meshes.push(view.kit.mesh(read));
  }
  const times = data.changes.map((c) => c[0]);
  // Index of the tool in the spindle; before the first change that of the block
  const toolAt = (time, step) => {
    const n = countUpTo(times, time);
    return n ? data.changes[n - 1][1] : run.toolOf(step);
  };
  // `from` is the frame that is drawn, from that of the machine
  const listAt = (time, step, places, from, shown) => {
    const list = [];
    const put = (mesh, pose, color, alpha = 1) => { if (mesh !== null && mesh !== undefined) list.push({ mesh: meshes[mesh], pose: Poses.times(from, pose), color, alpha }); };
    if (shown.machine !== 'hidden') {
      const alpha = shown.machine === 'clear' ? 0.2 : 1;
      for (const b of data.bodies) put(b.mesh, b.joint === null ? Poses.none : places.joints[b.joint], b.color, alpha);
    }
    if (shown.fixtures) for (const f of data.fixtures) put(f.mesh, places.table, f.color);
    const tool = data.tools[toolAt(time, step)];
    if (tool) {
      const tip = Poses.times(places.spindle, Poses.shift([0, 0, -tool.gauge]));
      for (const part of tool.parts) put(part.mesh, tip, part.color);
    }
    for (const part of data.loose) {
      const n = part.track.length && countUpTo(part.track.map((t) => t[0]), time);
      if (n && !(part.gone && n === part.track.length)) put(part.mesh, Poses.times(places.table, part.track[n - 1][1]), part.color);
    }
    if (shown.design) put(data.design, places.work, [60, 170, 110], 0.35);
    return list;
  };
  return { toolAt, listAt };
};
