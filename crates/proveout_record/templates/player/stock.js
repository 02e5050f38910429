// The stock at the moments that are kept: the meshes of its tiles as of the last moment up to a time. Reads what player/stock_moments.rs packs.
const stockOf = (view, bytes) => {
  'use strict';
  const head = new DataView(bytes.buffer, bytes.byteOffset);
  const [groups, moments, parts] = [0, 4, 8].map((o) => head.getUint32(o, true));
  const times = new Float64Array(moments), moment = new Uint32Array(parts), group = new Uint32Array(parts), length = new Float64Array(parts);
  let at = numbersAt(bytes, 12, moments, times);
  for (const list of [moment, group, length]) at = numbersAt(bytes, at, parts, list);
  for (let k = 0; k < moments; k++) times[k] *= 1e-4;
  // By group: moments at which it changed, and where its meshes are
  const tiles = Array.from({ length: groups }, () => ({ moments: [], places: [], shown: -1, mesh: null }));
  for (let k = 0; k < parts; k++) {
    const tile = tiles[group[k]];
    tile.moments.push(moment[k]);
    tile.places.push([at, length[k]]);
    at += length[k];
  }
  return {
    times,
    // Meshes that are on the graphics card
    shown: () => tiles.map((tile) => tile.mesh).filter(Boolean),
    // The number of the last moment up to a time
    momentAt: (time) => countUpTo(times, time) - 1,
    // Meshes of a moment; those that differ from the ones before are read anew. `fresh` gets each of them.
    meshesAt(number, fresh) {
      const list = [];
      for (const tile of tiles) {
        const k = countUpTo(tile.moments, number) - 1;
        if (k !== tile.shown) {
          tile.mesh?.free();
          tile.mesh = null;
          tile.shown = k;
          if (k >= 0 && tile.places[k][1]) {
            tile.mesh = view.kit.mesh(meshAt(bytes, tile.places[k][0], { blocks: true }));
            fresh(tile.mesh);
          }
        }
        if (tile.mesh) list.push(tile.mesh);
      }
      return list;
    },
  };
};
