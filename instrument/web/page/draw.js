// Pictures on canvases: the image, the object in the field, and curves over time.
import { POINT } from "./wire.js";

const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

const greys = new Uint32Array(256);
for (let k = 0; k < 256; k++) greys[k] = 0xff000000 | (k << 16) | (k << 8) | k;

export function drawImage(canvas, image) {
  if (canvas.width !== image.columns || canvas.height !== image.rows) {
    canvas.width = image.columns;
    canvas.height = image.rows;
  }
  const context = canvas.getContext("2d"), data = context.createImageData(image.columns, image.rows);
  const words = new Uint32Array(data.data.buffer);
  for (let k = 0; k < words.length; k++) words[k] = greys[image.pixels[k]];
  context.putImageData(data, 0, 0);
}

// The image of frame 0, displaced to where the object is, with the way that its picture came.
export function drawField(canvas, imageCanvas, path, side, middle) {
  const context = canvas.getContext("2d"), scale = canvas.width / side;
  context.fillStyle = "#000";
  context.fillRect(0, 0, canvas.width, canvas.height);
  const n = path.length / POINT;
  const x = n ? path[POINT * (n - 1) + 1] * scale : 0, y = n ? path[POINT * (n - 1) + 2] * scale : 0;
  context.imageSmoothingEnabled = false;
  if (imageCanvas) context.drawImage(imageCanvas, x, y, canvas.width, canvas.height);
  if (n < 2) return;
  context.strokeStyle = "#f0a35e";
  context.lineWidth = 2;
  context.beginPath();
  const step = Math.max(1, Math.floor(n / 200));
  for (let k = 0; k < n; k += step) {
    context.lineTo(middle[0] * canvas.width + path[POINT * k + 1] * scale, middle[1] * canvas.height + path[POINT * k + 2] * scale);
  }
  context.lineTo(middle[0] * canvas.width + x, middle[1] * canvas.height + y);
  context.stroke();
  context.beginPath();
  context.arc(middle[0] * canvas.width + x, middle[1] * canvas.height + y, 5, 0, 2 * Math.PI);
  context.stroke();
}

// The middle of the light of an image, as shares of its sides.
export function middleOf(image) {
  const { columns, rows, pixels } = image;
  let sum = 0, x = 0, y = 0;
  for (let row = 0, k = 0; row < rows; row++) for (let column = 0; column < columns; column++, k++) {
    const value = pixels[k];
    if (value > 96) { sum += value; x += value * (column + 0.5); y += value * (row + 0.5); }
  }
  return sum ? [x / sum / columns, y / sum / rows] : [0.5, 0.5];
}

// A step of 1, 2 or 5 times a power of ten, so that about so many fit into the span.
export function step(span, wanted) {
  const raw = Math.max(span, 1e-9) / wanted, power = 10 ** Math.floor(Math.log10(raw)), over = raw / power;
  return power * (over < 1.5 ? 1 : over < 3.5 ? 2 : over < 7.5 ? 5 : 10);
}

// Curves: {time, lines: [{values, sigma, colour, width}], end, pxPerMm}; values in px, sigma a standard deviation or null.
export function drawCurves(canvas, curves) {
  const ratio = Math.min(2, devicePixelRatio || 1), box = canvas.getBoundingClientRect();
  const width = Math.round(box.width * ratio), height = Math.round(box.height * ratio);
  if (!width || !height) return;
  if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, box.width, box.height);
  const right = curves.pxPerMm ? 52 : 14, left = 48, top = 10, bottom = 34;
  const w = box.width - left - right, h = box.height - top - bottom;
  let low = 0, high = 1;
  for (const line of curves.lines) for (const value of line.values) if (Number.isFinite(value)) { if (value < low) low = value; if (value > high) high = value; }
  const margin = 0.06 * (high - low);
  low -= margin; high += margin;
  const end = Math.max(curves.end || 0, curves.time.length ? curves.time[curves.time.length - 1] : 0, 1e-6);
  const px = (t) => left + (t / end) * w, py = (v) => top + (1 - (v - low) / (high - low)) * h;
  const ink = colour("--ink"), quiet = colour("--quiet"), grid = colour("--line");
  context.font = "12px system-ui, sans-serif";
  context.lineWidth = 1;
  context.fillStyle = quiet;
  context.textBaseline = "middle";
  ticks(low, high, step(high - low, h / 46), (value, text) => {
    context.strokeStyle = grid;
    context.beginPath(); context.moveTo(left, py(value)); context.lineTo(left + w, py(value)); context.stroke();
    context.textAlign = "right";
    context.fillText(text, left - 7, py(value));
  });
  if (curves.pxPerMm) ticks(low / curves.pxPerMm, high / curves.pxPerMm, step((high - low) / curves.pxPerMm, h / 46), (value, text) => {
    context.textAlign = "left";
    context.fillText(text, left + w + 7, py(value * curves.pxPerMm));
  });
  context.textBaseline = "top";
  context.textAlign = "center";
  ticks(0, end, step(end, w / 80), (value, text) => {
    context.strokeStyle = grid;
    context.beginPath(); context.moveTo(px(value), top + h); context.lineTo(px(value), top + h + 4); context.stroke();
    context.fillText(text, px(value), top + h + 6);
  });
  context.fillText("time, s", left + w / 2, top + h + 20);
  context.textAlign = "left";
  context.textBaseline = "bottom";
  context.fillText("px", 6, top + h + 22);
  if (curves.pxPerMm) { context.textAlign = "right"; context.fillText("mm", box.width - 6, top + h + 22); }
  context.save();
  context.beginPath(); context.rect(left, top, w, h); context.clip();
  for (const line of curves.lines) if (line.sigma) {
    context.fillStyle = colour(line.colour);
    context.globalAlpha = 0.25;
    context.beginPath();
    curves.time.forEach((t, k) => context.lineTo(px(t), py((line.values[k] ?? NaN) + 2 * (line.sigma[k] ?? 0))));
    for (let k = curves.time.length - 1; k >= 0; k--) context.lineTo(px(curves.time[k]), py((line.values[k] ?? NaN) - 2 * (line.sigma[k] ?? 0)));
    context.fill();
    context.globalAlpha = 1;
  }
  for (const line of curves.lines) {
    context.strokeStyle = colour(line.colour);
    context.lineWidth = line.width;
    context.lineJoin = "round";
    context.beginPath();
    const every = Math.max(1, Math.floor(curves.time.length / (2 * w)));
    for (let k = 0; k < curves.time.length; k += every) context.lineTo(px(curves.time[k]), py(line.values[k] ?? NaN));
    context.stroke();
  }
  context.restore();
  context.strokeStyle = ink;
  context.lineWidth = 1;
  context.beginPath(); context.moveTo(left, top); context.lineTo(left, top + h); context.lineTo(left + w, top + h); context.stroke();
}

function ticks(low, high, size, draw) {
  const digits = Math.max(0, -Math.floor(Math.log10(size) + 1e-9));
  for (let k = Math.ceil(low / size); k * size <= high + 1e-9 * size; k++) draw(k * size, (k * size).toFixed(digits));
}
