"use strict";
/* The arrays of the page: base64 -> inflate -> 16-bit differences -> integers with a range each. */
const viscorod = {};

viscorod.read = async function () {
  const meta = JSON.parse(document.getElementById("meta").textContent);
  const text = atob(document.getElementById("data").textContent.trim());
  const packed = new Uint8Array(text.length);
  for (let k = 0; k < text.length; k++) packed[k] = text.charCodeAt(k);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const buffer = await new Response(stream).arrayBuffer();
  const arrays = {};
  for (const [name, entry] of Object.entries(meta.arrays)) arrays[name] = viscorod.array(buffer, entry);
  return { meta, arrays };
};

viscorod.array = function (buffer, entry) {
  const { offset, bytes, shape, kind } = entry;
  if (kind === "float32") return { shape, values: new Float32Array(buffer, offset, bytes / 4) };
  if (kind === "uint32") return { shape, values: new Uint32Array(buffer, offset, bytes / 4) };
  const halves = new Uint8Array(buffer, offset, bytes);
  const count = bytes / 2;
  const row = shape[0] ? count / shape[0] : 0;
  const whole = new Uint16Array(count);
  for (let k = 0; k < count; k++) {
    const change = halves[k] | (halves[count + k] << 8);
    whole[k] = k < row ? change : whole[k - row] + change; // wraps as it did when it was written
  }
  return { shape, row, whole, low: entry.low, step: entry.step };
};

/* Values of a quantised array between frames k and k + 1, written to `out`; `turns`: quaternions of either sign. */
viscorod.between = function (array, k, part, out, turns = false) {
  const { whole, row, low, step } = array;
  const c = low.length;
  const last = array.shape[0] - 1;
  const a = Math.min(k, last) * row;
  const b = Math.min(k + 1, last) * row;
  for (let j = 0; j < row; j++) {
    const m = j % c;
    const from = low[m] + step[m] * whole[a + j];
    out[j] = from + part * (low[m] + step[m] * whole[b + j] - from);
  }
  if (turns) {
    for (let j = 0; j < row; j += 4) {
      let dot = 0;
      for (let i = 0; i < 4; i++) dot += (low[0] + step[0] * whole[a + j + i]) * (low[0] + step[0] * whole[b + j + i]);
      if (dot >= 0) continue;
      for (let i = 0; i < 4; i++) {
        out[j + i] = (1 - part) * (low[0] + step[0] * whole[a + j + i]) - part * (low[0] + step[0] * whole[b + j + i]);
      }
    }
  }
  return out;
};

/* A number with its unit's worth of digits, and a true minus sign. */
viscorod.text = function (value, digits = 4) {
  if (value === 0 || !Number.isFinite(value)) return "0";
  const size = Math.abs(value);
  let text = String(Number(value.toPrecision(digits)));
  if (size >= 1e5 || size < 1e-3) {
    const [mantissa, power] = value.toExponential(Math.max(digits - 2, 1)).split("e");
    text = `${Number(mantissa)}e${Number(power)}`;
  }
  return text.replace(/-/g, "\u2212");
};

/* A number with its unit and an engineering prefix. */
viscorod.prefixed = function (value, unit, digits = 3) {
  if (!value) return `0 ${unit}`;
  const power = Math.max(-8, Math.min(5, Math.floor(Math.log10(Math.abs(value) * (1 + 1e-12)) / 3)));
  const prefix = ["y", "z", "a", "f", "p", "n", "\u00b5", "m", "", "k", "M", "G", "T", "P"][power + 8];
  return `${viscorod.text(value / 10 ** (3 * power), digits)} ${prefix}${unit}`;
};

/* A colour of the page, which is light or dark. */
viscorod.style = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

/* Begin as the reader's system is, light or dark; the button changes it. */
viscorod.theme = function (button, changed) {
  const root = document.documentElement;
  const set = (dark) => {
    root.toggleAttribute("data-dark", dark);
    button.setAttribute("aria-pressed", String(dark));
    button.textContent = dark ? "Light" : "Dark";
    changed();
  };
  button.addEventListener("click", () => set(!root.hasAttribute("data-dark")));
  set(window.matchMedia("(prefers-color-scheme: dark)").matches);
};

/* Give the reader a file. */
viscorod.hand = function (blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
};
