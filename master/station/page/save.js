// Files that the browser downloads.

export function save(blob, name) {
  const anchor = document.createElement('a');
  anchor.href = URL.createObjectURL(blob);
  anchor.download = name;
  anchor.click();
  setTimeout(() => URL.revokeObjectURL(anchor.href), 1000);
}

// The visible object and charts in one PNG.
export function saveImage(view) {
  view.dirty = true;
  view.draw();  // WebGL keeps what it drew until the frame ends alone
  const page = document.querySelector('main').getBoundingClientRect(), style = getComputedStyle(document.documentElement), ratio = devicePixelRatio;
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
