// Vectors, and poses as twelve numbers: three rows of a rotation, each with its part of the translation at the end.
const Vectors = {
  dot: (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2],
  cross: (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]],
  less: (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]],
  along: (p, d, t) => [p[0] + t * d[0], p[1] + t * d[1], p[2] + t * d[2]],
};
const Poses = (() => {
  'use strict';
  const none = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0];
  const shift = (v) => [1, 0, 0, v[0], 0, 1, 0, v[1], 0, 0, 1, v[2]];
  // a_from_c of a_from_b and b_from_c
  const times = (a, b) => {
    const out = new Array(12);
    for (let i = 0; i < 12; i += 4) {
      for (let k = 0; k < 4; k++) out[i + k] = a[i] * b[k] + a[i + 1] * b[4 + k] + a[i + 2] * b[8 + k] + (k === 3 ? a[i + 3] : 0);
    }
    return out;
  };
  const inverse = (a) => {
    const back = (k) => -(a[k] * a[3] + a[4 + k] * a[7] + a[8 + k] * a[11]);
    return [a[0], a[4], a[8], back(0), a[1], a[5], a[9], back(1), a[2], a[6], a[10], back(2)];
  };
  const point = (a, p) => [0, 4, 8].map((i) => a[i] * p[0] + a[i + 1] * p[1] + a[i + 2] * p[2] + a[i + 3]);
  const direction = (a, v) => [0, 4, 8].map((i) => a[i] * v[0] + a[i + 1] * v[1] + a[i + 2] * v[2]);
  // Turn about a line through a point, right-handed (Rodrigues 1840)
  const aboutLine = (through, [x, y, z], angle) => {
    const s = Math.sin(angle), c = Math.cos(angle), d = 1 - c;
    const turn = [
      c + x * x * d, x * y * d - z * s, x * z * d + y * s, 0,
      y * x * d + z * s, c + y * y * d, y * z * d - x * s, 0,
      z * x * d - y * s, z * y * d + x * s, c + z * z * d, 0,
    ];
    const moved = point(turn, through);
    for (let k = 0; k < 3; k++) turn[4 * k + 3] = through[k] - moved[k];
    return turn;
  };
  // The sixteen numbers of a shader's matrix, column by column, of a matrix (such as a projection) and a pose
  const under = (m, a) => {
    const out = new Float32Array(16);
    for (let column = 0; column < 4; column++) {
      for (let row = 0; row < 4; row++) {
        out[4 * column + row] = m[row] * a[column] + m[4 + row] * a[4 + column] + m[8 + row] * a[8 + column] + (column === 3 ? m[12 + row] : 0);
      }
    }
    return out;
  };
  return { none, shift, times, inverse, point, direction, aboutLine, under };
})();
