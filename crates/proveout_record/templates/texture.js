// Roughness maps: heights as 16 bit over a range; a click draws the profiles along the row and the column through it.
(() => {
  'use strict';
  const bytesOf = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const { maps, colors } = JSON.parse(document.getElementById('texture-data').textContent);
  const ramp = bytesOf(colors), plain = [158, 164, 172], none = 65535;
  document.querySelectorAll('figure[data-map]').forEach((figure) => {
    const { columns, rows, step, range, heights } = maps[figure.dataset.map], bytes = bytesOf(heights);
    const canvas = figure.querySelector('canvas'), plot = figure.querySelector('svg'), words = figure.querySelector('.at');
    const level = (i, j) => { const k = 2 * (j * columns + i); return bytes[k] | bytes[k + 1] << 8; };
    const height = (v) => range[0] + (range[1] - range[0]) * v / 65534;
    canvas.width = columns;
    canvas.height = rows;
    const context = canvas.getContext('2d'), image = context.createImageData(columns, rows);
    for (let j = 0; j < rows; j++) {
      for (let i = 0; i < columns; i++) {
        const v = level(i, j), from = 3 * Math.round(v * 255 / 65534);
        // Rows run upward.
        image.data.set([...(v === none ? plain : ramp.slice(from, from + 3)), 255], 4 * ((rows - 1 - j) * columns + i));
      }
    }
    const label = (v) => Math.abs(v) < 1e-6 ? '0' : v.toPrecision(3);
    const line = (points, name, size) => {
      const span = Math.max(range[1] - range[0], 1e-9);
      let text = '', pen = 'M';
      points.forEach((v, k) => {
        if (v === none) { pen = 'M'; return; }
        text += `${pen}${(40 + 350 * k / (points.length - 1)).toFixed(1)} ${(size + 78 - 60 * (height(v) - range[0]) / span).toFixed(1)}`;
        pen = 'L';
      });
      return `<rect class="frame" x="40" y="${size + 16}" width="350" height="64"/><path class="second" d="${text}"/>` +
        `<text x="36" y="${size + 24}" text-anchor="end">${label(range[1])}</text><text x="36" y="${size + 80}" text-anchor="end">${label(range[0])}</text><text x="40" y="${size + 11}">${name}</text>`;
    };
    const show = (i, j) => {
      context.putImageData(image, 0, 0);
      context.fillStyle = 'rgba(214, 40, 57, 0.75)';
      context.fillRect(i, 0, Math.max(1, columns / 300), rows);
      context.fillRect(0, rows - 1 - j, columns, Math.max(1, rows / 300));
      const row = Array.from({ length: columns }, (_, k) => level(k, j)), column = Array.from({ length: rows }, (_, k) => level(i, k));
      plot.innerHTML = line(row, `along the row, 0 to ${((columns - 1) * step[0]).toFixed(2)} mm, µm`, 0) + line(column, `along the column, 0 to ${((rows - 1) * step[1]).toFixed(2)} mm, µm`, 88);
      const v = level(i, j);
      words.textContent = `At ${(i * step[0]).toFixed(3)}, ${(j * step[1]).toFixed(3)} mm: ${v === none ? 'not cut' : height(v).toFixed(3) + ' µm'}`;
    };
    canvas.addEventListener('click', (event) => {
      const box = canvas.getBoundingClientRect(), at = (t, n) => Math.min(n - 1, Math.max(0, Math.floor(t * n)));
      show(at((event.clientX - box.left) / box.width, columns), rows - 1 - at((event.clientY - box.top) / box.height, rows));
    });
    show(columns >> 1, rows >> 1);
  });
})();
