// The arrays of the page: one compressed block, from which each array is read by its position.

const head = JSON.parse(document.getElementById("head").textContent);
const KINDS = { f4: Float32Array, f8: Float64Array, i2: Int16Array, i4: Int32Array };

async function inflated() {
  const text = atob(document.getElementById("data").textContent);
  const bytes = Uint8Array.from(text, (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// Bytes are stored plane by plane; whole numbers are differences along the last axis.
function arrayOf(block, { start, shape, kind }) {
  const values = new KINDS[kind](shape.reduce((product, n) => product * n, 1));
  const number = values.length,
    width = values.BYTES_PER_ELEMENT;
  const bytes = new Uint8Array(values.buffer);
  for (let plane = 0; plane < width; plane++) {
    const from = start + plane * number;
    for (let i = 0; i < number; i++) bytes[i * width + plane] = block[from + i];
  }
  const row = shape[shape.length - 1];
  if (kind[0] === "i") for (let i = 1; i < number; i++) if (i % row) values[i] += values[i - 1];
  return values;
}

// Numbers for display: four digits, without exponent if possible.
function shownNumber(value, digits = 4) {
  const rounded = +value.toPrecision(digits),
    size = Math.abs(rounded);
  return rounded === 0 || (size >= 1e-4 && size < 1e6) ? String(rounded) : rounded.toExponential();
}

const measured = (value, unit, digits) => shownNumber(value, digits) + (unit ? ` ${unit}` : "");
