// Settings stored by the browser, and downloaded files.

export function save(blob, name) {
  const anchor = document.createElement('a');
  anchor.href = URL.createObjectURL(blob);
  anchor.download = name;
  anchor.click();
  setTimeout(() => URL.revokeObjectURL(anchor.href), 1000);
}

// Returns a stored setting of this browser; null if it stores none.
export function kept(name) {
  try {
    return localStorage.getItem(name);
  } catch {
    return null;
  }
}
export function keep(name, value) {
  try {
    localStorage.setItem(name, value);
  } catch {}
}

// Saves the visible object and charts in one PNG.
export function saveImage(view) {
  view.dirty = true;
  view.draw();  // WebGL keeps its image only until the frame ends
  const page = document.querySelector('main').getBoundingClientRect(),
    style = getComputedStyle(document.documentElement),
    ratio = devicePixelRatio;
  const canvas = document.createElement('canvas'), pen = canvas.getContext('2d');
  [canvas.width, canvas.height] = [page.width * ratio, page.height * ratio];
  pen.scale(ratio, ratio);
  pen.fillStyle = style.getPropertyValue('--panel');
  pen.fillRect(0, 0, page.width, page.height);
  for (const drawn of document.querySelectorAll('#view canvas, .strip canvas')) {
    const { x, y, width, height } = drawn.getBoundingClientRect();
    if (width) pen.drawImage(drawn, x - page.x, y - page.y, width, height);
  }
  pen.fillStyle = style.getPropertyValue('--text');
  for (const words of document.querySelectorAll('.strip h3, .strip .key, #view-line, .force-label, .colour-bar b, .colour-bar em')) {
    const { x, y, width, height } = words.getBoundingClientRect();
    pen.font = getComputedStyle(words).font;
    if (width) pen.fillText(words.textContent, x - page.x, y - page.y + 0.8 * height);
  }
  canvas.toBlob((blob) => save(blob, 'palpate-view.png'), 'image/png');
}

const CRCS = Uint32Array.from({ length: 256 }, (_, n) => {
  for (let k = 0; k < 8; ++k) n = n & 1 ? 0xedb88320 ^ (n >>> 1) : n >>> 1;
  return n;
});
const crcOf = (bytes) => bytes.reduce((crc, byte) => CRCS[(crc ^ byte) & 255] ^ (crc >>> 8), 0xffffffff) ^ 0xffffffff;

// Packs files {name: Uint8Array} into one zip file without compression.
export function zipOf(files) {
  const parts = [], directory = [];
  let at = 0;
  const add = (list, bytes) => (list.push(bytes), bytes.length);
  const fields = (...values) => {
    const view = new DataView(new ArrayBuffer(values.reduce((sum, [, size]) => sum + size, 0)));
    let to = 0;
    for (const [value, size] of values) {
      if (size === 4) view.setUint32(to, value, true);
      else view.setUint16(to, value, true);
      to += size;
    }
    return new Uint8Array(view.buffer);
  };
  for (const [name, bytes] of Object.entries(files)) {
    const title = new TextEncoder().encode(name), year1980 = (1 << 5) | 1;
    const common = [
      [20, 2],
      [0x800, 2],
      [0, 2],
      [0, 2],
      [year1980, 2],
      [crcOf(bytes) >>> 0, 4],
      [bytes.length, 4],
      [bytes.length, 4],
      [title.length, 2],
      [0, 2],
    ];
    const start = at;
    for (const part of [fields([0x04034b50, 4], ...common), title, bytes]) at += add(parts, part);
    directory.push(fields([0x02014b50, 4], [20, 2], ...common, [0, 2], [0, 2], [0, 2], [0, 4], [start, 4]), title);
  }
  const size = directory.reduce((sum, part) => sum + part.length, 0), count = directory.length / 2;
  const all = [...parts, ...directory, fields([0x06054b50, 4], [0, 2], [0, 2], [count, 2], [count, 2], [size, 4], [at, 4], [0, 2])];
  const joined = new Uint8Array(all.reduce((sum, part) => sum + part.length, 0));
  let to = 0;
  for (const part of all) joined.set(part, (to += part.length) - part.length);
  return joined;
}
