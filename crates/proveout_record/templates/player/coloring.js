// Colors of a surface by the block that cut it: its tool, its operation, the part of the programmed feed that it reached.
const coloringOf = (view, run) => {
  'use strict';
  const { steps, data } = run;
  // Tag 0 is the raw skin.
  const raw = [158, 164, 172];
  const hues = [[86, 140, 214], [226, 140, 60], [92, 170, 100], [190, 96, 170], [200, 176, 60], [80, 180, 190], [214, 92, 92], [130, 110, 210]];
  const classes = [[0.95, '95 % and more', [64, 148, 232]], [0.8, '80 %', [70, 190, 190]], [0.6, '60 %', [110, 190, 90]], [0.4, '40 %', [230, 200, 60]], [0.2, '20 %', [240, 130, 50]], [0, 'less than 20 %', [226, 60, 60]]];
  const reached = (k) => {
    const time = steps.end[k] - run.begin(k);
    return steps.feed[k] > 0 && time > 0 && steps.length[k] > 0 ? 60 * steps.length[k] / time / steps.feed[k] : null;
  };
  const operations = data.jumps.operations;
  const starts = operations.map((o) => o.time);
  const ways = {
    tool: {
      tag: (k) => { const tool = run.toolOf(k); return tool === null ? 0 : tool % 254 + 1; },
      name: (tag) => data.tools[tag - 1]?.name || `tool ${tag}`,
      color: (tag) => hues[(tag - 1) % hues.length],
    },
    operation: {
      tag: (k) => Math.max(0, countUpTo(starts, run.begin(k) + 1e-4)) % 255,
      name: (tag) => operations[tag - 1]?.text || `operation ${tag}`,
      color: (tag) => hues[(tag - 1) % hues.length],
    },
    feed: {
      tag: (k) => { const part = reached(k); return part === null ? 0 : 1 + classes.findIndex((c) => part >= c[0] - 1e-6); },
      name: (tag) => classes[tag - 1][1],
      color: (tag) => classes[tag - 1][2],
    },
  };
  let table = null, chosen = '';
  const used = new Set();
  const paint = (mesh) => {
    if (!table || !mesh.blocks.length) return;
    const tags = new Uint8Array(mesh.blocks.length);
    for (let i = 0; i < tags.length; i++) { const block = mesh.blocks[i]; tags[i] = block ? table[Math.min(block - 1, table.length - 1)] : 0; }
    mesh.setTags(tags);
  };
  return {
    paint,
    // Chooses a way, or none (''); returns the rows of the legend: color and name
    choose(name) {
      chosen = ways[name] ? name : '';
      table = null;
      if (!chosen) return [];
      const way = ways[chosen], last = steps.count ? steps.block[steps.count - 1] : 0;
      table = new Uint8Array(last + 1);
      used.clear();
      for (let k = 0; k < steps.count; k++) {
        const tag = way.tag(k), next = k + 1 < steps.count ? steps.block[k + 1] : last + 1;
        table.fill(tag, steps.block[k], next);
        if (tag) used.add(tag);
      }
      const colors = new Uint8Array(768);
      for (let tag = 0; tag < 256; tag++) colors.set(tag && used.has(tag) ? way.color(tag) : raw, 3 * tag);
      view.setTable(colors);
      paint(view.body);
      return [...used].sort((a, b) => a - b).map((tag) => ({ color: way.color(tag), name: way.name(tag) }));
    },
    chosen: () => chosen,
    reached,
  };
};
