// Programs, meshes, paths and colors on the graphics card.
const graphicsOf = (gl) => {
  'use strict';
  const compile = (kind, text) => { const s = gl.createShader(kind); gl.shaderSource(s, text); gl.compileShader(s); return s; };
  const linked = ([vertexText, fragmentText]) => {
    const program = gl.createProgram();
    gl.attachShader(program, compile(gl.VERTEX_SHADER, '#version 300 es\n' + vertexText));
    gl.attachShader(program, compile(gl.FRAGMENT_SHADER, '#version 300 es\nprecision highp float;\nprecision highp int;\n' + fragmentText));
    gl.linkProgram(program);
    const slots = {};
    return { program, ok: gl.getProgramParameter(program, gl.LINK_STATUS), at: (name) => slots[name] ??= gl.getUniformLocation(program, name) };
  };
  const programs = Object.fromEntries(Object.entries(Shaders).map(([name, texts]) => [name, linked(texts)]));
  const buffer = (slot, array, width, type, normalized, whole) => {
    const made = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, made);
    gl.bufferData(gl.ARRAY_BUFFER, array, gl.STATIC_DRAW);
    gl.enableVertexAttribArray(slot);
    if (whole) gl.vertexAttribIPointer(slot, width, type, 0, 0); else gl.vertexAttribPointer(slot, width, type, normalized, 0, 0);
    return made;
  };
  // A mesh as `meshAt` reads it; `count` is that of its indices.
  const mesh = (data) => {
    const array = gl.createVertexArray(), buffers = [];
    gl.bindVertexArray(array);
    buffers.push(buffer(0, data.positions, 3, gl.UNSIGNED_SHORT, true), buffer(1, data.normals, 3, gl.BYTE, true));
    const colors = data.colors && (data.values ? buffer(2, data.colors, 1, gl.HALF_FLOAT, false) : buffer(2, data.colors, 1, gl.UNSIGNED_BYTE, true));
    if (colors) buffers.push(colors);
    if (data.blocks.length) buffers.push(buffer(3, data.blocks, 1, gl.UNSIGNED_INT, false, true));
    const indices = gl.createBuffer();
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, indices);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, data.indices, gl.STATIC_DRAW);
    buffers.push(indices);
    gl.bindVertexArray(null);
    let tags = null;
    return {
      array, low: data.low, size: data.size, count: data.indices.length, mode: data.values ? 2 : data.colors ? 1 : 0,
      blocks: data.blocks,
      setColors(bytes) { if (colors) { gl.bindBuffer(gl.ARRAY_BUFFER, colors); gl.bufferData(gl.ARRAY_BUFFER, bytes, gl.STATIC_DRAW); } },
      // One byte a vertex: a place in the table of tags
      setTags(bytes) {
        gl.bindVertexArray(array);
        if (tags) { gl.bindBuffer(gl.ARRAY_BUFFER, tags); gl.bufferData(gl.ARRAY_BUFFER, bytes, gl.STATIC_DRAW); } else { tags = buffer(4, bytes, 1, gl.UNSIGNED_BYTE, true); buffers.push(tags); }
        gl.bindVertexArray(null);
      },
      free() { buffers.forEach((b) => gl.deleteBuffer(b)); gl.deleteVertexArray(array); },
    };
  };
  // Segments of seven numbers: from, to, kind
  const path = (segments) => {
    const array = gl.createVertexArray(), made = gl.createBuffer();
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ARRAY_BUFFER, made);
    gl.bufferData(gl.ARRAY_BUFFER, segments, gl.STATIC_DRAW);
    [[3, 0], [3, 12], [1, 24]].forEach(([width, offset], slot) => {
      gl.enableVertexAttribArray(slot);
      gl.vertexAttribPointer(slot, width, gl.FLOAT, false, 28, offset);
      gl.vertexAttribDivisor(slot, 1);
    });
    gl.bindVertexArray(null);
    return { array, count: segments.length / 7, free() { gl.deleteBuffer(made); gl.deleteVertexArray(array); } };
  };
  // A square in three dimensions whose corners are given anew each time
  const square = (() => {
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    const made = buffer(0, new Float32Array(12), 3, gl.FLOAT, false);
    gl.bindVertexArray(null);
    return {
      draw(corners) {
        gl.bindVertexArray(array);
        gl.bindBuffer(gl.ARRAY_BUFFER, made);
        gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(corners), gl.DYNAMIC_DRAW);
        gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
      },
    };
  })();
  // 256 colors at a texture unit; `smooth` between them
  const colorTable = (unit, bytes, smooth) => {
    const texture = gl.createTexture();
    const set = (table) => {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, texture);
      gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB, 256, 1, 0, gl.RGB, gl.UNSIGNED_BYTE, table);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, smooth ? gl.LINEAR : gl.NEAREST);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, smooth ? gl.LINEAR : gl.NEAREST);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    };
    set(bytes);
    return set;
  };
  // Vertices of meshes without blocks belong to none.
  gl.vertexAttribI4ui(3, 0, 0, 0, 0);
  gl.enable(gl.DEPTH_TEST);
  return { programs, ok: Object.values(programs).every((p) => p.ok), mesh, path, square, colorTable };
};
