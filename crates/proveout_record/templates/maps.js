// Maps of values laid flat: one byte a cell, 254 steps of the color map, 255 for no value. Reads what part.rs has packed.
(() => {
  'use strict';
  const bytesOf = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const maps = JSON.parse(document.getElementById('map-data').textContent);
  const part = JSON.parse(document.getElementById('part-data').textContent), colors = bytesOf(part.map);
  document.querySelectorAll('canvas[data-cells]').forEach((canvas) => {
    const { columns, rows, cells } = maps[canvas.dataset.cells], bytes = bytesOf(cells);
    canvas.width = columns;
    canvas.height = rows;
    const context = canvas.getContext('2d'), image = context.createImageData(columns, rows);
    bytes.forEach((b, i) => {
      const from = 3 * Math.min(255, Math.round(b * 255 / 254));
      const color = b === 255 ? part.plain : [colors[from], colors[from + 1], colors[from + 2]];
      image.data.set([...color, 255], 4 * i);
    });
    context.putImageData(image, 0, 0);
  });
})();
