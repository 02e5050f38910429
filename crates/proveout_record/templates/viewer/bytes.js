// Bytes of the page: Base64, deflate, whole numbers as their differences, meshes. Reads what page_encoding.rs packs.
const bytesOf = (text) => Uint8Array.from(atob(text.trim()), (c) => c.charCodeAt(0));
// The text leaves the page once it is read: it would stay in memory twice.
const inflated = async (id) => {
  const element = document.getElementById(id);
  if (!element || !element.textContent.trim()) return null;
  const packed = new Blob([bytesOf(element.textContent)]).stream().pipeThrough(new DecompressionStream('deflate'));
  element.textContent = '';
  return new Uint8Array(await new Response(packed).arrayBuffer());
};
// `count` numbers into an array, at every `stride`-th place from `first`; returns where the next bytes begin.
const numbersAt = (bytes, at, count, into, stride = 1, first = 0) => {
  let last = 0;
  for (let i = 0, k = first; i < count; i++, k += stride) {
    let byte = bytes[at++];
    let code = byte & 127;
    if (byte > 127) {
      let factor = 128;
      do { byte = bytes[at++]; code += (byte & 127) * factor; factor *= 128; } while (byte > 127);
    }
    last += code % 2 ? -(code + 1) / 2 : code / 2;
    into[k] = last;
  }
  return at;
};
// A mesh that begins at a place; `next` is where it ends.
const meshAt = (bytes, at, { values = false, shades = false, blocks = false } = {}) => {
  const head = new DataView(bytes.buffer, bytes.byteOffset);
  const vertices = head.getUint32(at, true), triangles = head.getUint32(at + 4, true);
  const low = [8, 12, 16].map((o) => head.getFloat32(at + o, true)), size = [20, 24, 28].map((o) => head.getFloat32(at + o, true));
  at += 32;
  const positions = new Uint16Array(3 * vertices), normals = new Int8Array(3 * vertices);
  for (let k = 0; k < 3; k++) at = numbersAt(bytes, at, vertices, positions, 3, k);
  for (let k = 0; k < 3; k++) {
    let last = 0;
    for (let i = k; i < normals.length; i += 3) normals[i] = last = last + bytes[at++] & 255;
  }
  const cut = (length) => bytes.slice(at, at += length);
  const colors = values ? new Uint16Array(cut(2 * vertices).buffer) : shades ? cut(vertices) : null;
  const made = new Uint32Array(blocks ? vertices : 0);
  if (blocks) at = numbersAt(bytes, at, vertices, made);
  const indices = new Uint32Array(3 * triangles);
  at = numbersAt(bytes, at, indices.length, indices);
  return { vertices, low, size, positions, normals, colors, values, blocks: made, indices, next: at };
};
