// Map coordinates and height of the place under the pointer, in words.

export function showPlace(line, canvas, stage, frame, { digits, heightDigits, unit }) {
  const hint = line.textContent;
  let waiting = false, pointer;
  canvas.addEventListener('pointermove', event => {
    pointer = event;
    // One look for each frame that is drawn is enough.
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => {
      waiting = false;
      say();
    });
  });
  canvas.addEventListener('pointerleave', () => { line.textContent = hint; });

  function say() {
    const { left, top, width, height } = canvas.getBoundingClientRect();
    const place = stage.at(((pointer.clientX - left) / width) * 2 - 1, 1 - ((pointer.clientY - top) / height) * 2);
    if (!place) return void (line.textContent = hint);
    const [x, y, z] = frame.toMap(place);
    line.textContent = `x ${x.toFixed(digits)}, y ${y.toFixed(digits)}, height ${z.toFixed(heightDigits)}${unit}`;
  }
}
