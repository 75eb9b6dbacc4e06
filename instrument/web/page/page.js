// The page: takes what the server tells, and draws it once for each picture of the screen.
import { POINT, read } from "./wire.js";
import { drawCurves, drawField, drawImage, middleOf, step } from "./draw.js";
import { list, redraw } from "./past.js";

const STATE_VERSION = 1, WAITING = 3, KEPT = 4096, PLOT_EVERY_MS = 100, FIELD_EVERY_MS = 45, LATE_MS = 25;
const at = (id) => document.getElementById(id);

export function put(id, words) {
  const element = at(id);
  if (element.textContent !== words) element.textContent = words;
}

export function fact(what, value) {
  const name = document.createElement("dt"), told = document.createElement("dd");
  name.textContent = what;
  told.textContent = value;
  return [name, told];
}

const images = [];          // arrived and not drawn yet, at most WAITING
let path = new Float32Array(0), state = null, image = null, socket = null, runs = -1, pathDue = false, fieldDue = false;
// What has been seen, for the line at the bottom and for whoever measures.
const seen = { images: 0, skipped: 0, dropped: 0, delays_ms: [], lags: [], painted_ms: [] };
window.kinopix = { seen, get state() { return state; }, get points() { return path.length / POINT; } };

function connect() {
  socket = new WebSocket(`ws://${location.host}/live`);
  socket.binaryType = "arraybuffer";
  socket.onopen = () => { banner(""); list(); };
  socket.onmessage = ({ data }) => (typeof data === "string" ? takeState(JSON.parse(data)) : takeFrame(read(data)));
  socket.onclose = ({ code, reason }) => {
    banner(code === 1008 || code === 1013 ? reason : state?.run?.finished ? "The server has ended; this is the last that it told." : "No connection to the server; trying again.");
    controls([]);
    setTimeout(connect, 1000);
  };
}

function banner(words) {
  put("banner", words);
  at("banner").hidden = !words;
}

function takeFrame(frame) {
  if (frame.kind === 1) {
    seen.skipped = frame.skipped;
    images.push({ ...frame, arrived_ms: performance.now() });
    if (images.length > WAITING) { images.shift(); seen.dropped++; }
  } else {
    const length = POINT * frame.first;
    const joined = new Float32Array(length + frame.points.length);
    joined.set(path.subarray(0, length));
    joined.set(frame.points, length);
    path = joined;
    pathDue = fieldDue = true;
  }
  due();
}

let asked = false, plotted_ms = 0, fielded_ms = 0;
function due() {
  if (!asked) { asked = true; requestAnimationFrame(paint); }
}

function paint() {
  asked = false;
  while (images.length > 1 && performance.now() - images[0].arrived_ms > LATE_MS) { images.shift(); seen.dropped++; }
  const next = images.shift();
  if (next) {
    image = next;
    drawImage(at("image"), next);
    at("noimage").hidden = true;
    put("white", `0 to ${next.white.toPrecision(3)}`);
    fieldDue = true;
  }
  if (fieldDue && performance.now() - fielded_ms >= FIELD_EVERY_MS) { fielded_ms = performance.now(); drawField(at("field"), image ? at("image") : null, path, state?.plan?.image_size ?? image?.columns ?? 128, image ? middleOf(image) : [0.5, 0.5]); fieldDue = false; }
  if (pathDue && performance.now() - plotted_ms >= PLOT_EVERY_MS) { plot(); pathDue = false; plotted_ms = performance.now(); }
  if ((pathDue || fieldDue) && !images.length) setTimeout(due, fieldDue ? FIELD_EVERY_MS : PLOT_EVERY_MS);
  if (next) afterPaint(() => {
    const now_s = (performance.timeOrigin + performance.now()) / 1000;
    seen.images++;
    seen.delays_ms.push(1000 * (now_s - next.sent_s));
    seen.lags.push([next.frames, now_s]);
    seen.painted_ms.push(performance.now());
    for (const kept of [seen.delays_ms, seen.lags, seen.painted_ms]) if (kept.length > KEPT) kept.shift();
    if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify({ seen: next.sequence }));
  });
  if (images.length) due();
}

// Called when the picture that is being made now has been handed to the screen.
const after = new MessageChannel(), waiting = [];
after.port1.onmessage = () => waiting.shift()();
function afterPaint(call) { waiting.push(call); after.port2.postMessage(0); }

function plot() {
  const n = path.length / POINT, column = (which) => Array.from({ length: n }, (_, k) => path[POINT * k + which]);
  const [time, x, y, sigmaX, sigmaY] = [0, 1, 2, 3, 4].map(column);
  drawCurves(at("path"), { time, end: state?.plan?.run_time_s, pxPerMm: state?.px_per_mm, lines: [
    { values: x, sigma: sigmaX, colour: "--x", width: 4 }, { values: y, sigma: sigmaY, colour: "--y", width: 1.8 } ] });
}

function takeState(next) {
  if (next.version !== STATE_VERSION) { banner("The server is of another version: load the page anew."); return; }
  const before = state;
  state = next;
  document.title = `${next.doing} - Kinopix`;
  put("title", next.title);
  const chip = at("state"), run = next.run;
  chip.dataset.state = run && next.doing !== "at rest" ? run.state : "rest";
  put("state", run && !run.finished ? run.state : next.doing);
  put("notice", next.notice);
  at("notice").hidden = !next.notice;
  at("controls").hidden = !next.control;
  controls(next.offers);
  if (runs >= 0 && next.runs !== runs && before) clear();
  runs = next.runs;
  showRun(next, run);
  showLight(next.light);
  showLive(next.live, next.px_per_mm);
  lines("findings", "nofindings", (run?.findings ?? []).slice(-50), (item, words) => { item.textContent = words; });
  lines("checks", "nochecks", next.checks, (item, check) => item.append(badge(check.outcome), `${check.name}: ${check.message}`));
  lines("devices", "nodevices", next.devices, showDevice);
  if (run?.finished && !before?.run?.finished && before) setTimeout(list, 500);
  pathDue ||= !before || before.plan?.run_time_s !== next.plan?.run_time_s;
  if (pathDue) due();
}

function clear() {
  images.length = 0;
  image = null;
  for (const id of ["image", "field"]) { const canvas = at(id); canvas.getContext("2d").clearRect(0, 0, canvas.width, canvas.height); }
  at("noimage").hidden = false;
}

function showRun(next, run) {
  const bar = at("done");
  put("plan", next.plan?.words ?? "");
  if (!run) { put("phase", "no run yet"); bar.value = 0; put("patterns", next.plan ? `${next.plan.frames} frames in ${next.plan.run_time_s.toPrecision(3)} s` : "-"); at("ended").hidden = true; return; }
  const uploading = run.phase === "uploading" && run.upload_total > 0;
  put("phase", run.finished ? "over" : run.phase ?? "begins");
  bar.value = uploading ? run.upload_done / run.upload_total : run.patterns_done / Math.max(1, run.patterns_total);
  put("patterns", uploading ? `${run.upload_done} of ${run.upload_total} patterns uploaded` : `${run.patterns_done} of ${run.patterns_total} patterns counted`);
  put("file", run.path);
  const ended = run.finished;
  at("ended").hidden = !ended;
  if (ended) {
    at("ended").dataset.outcome = ended.outcome;
    put("ended", [ended.outcome === "done" ? `Done; timing audit: ${ended.verdict}.` : `${ended.outcome}: ${ended.error}`, ...ended.notes].join("\n"));
  }
}

const rate = (hz) => hz >= 1e6 ? `${(hz / 1e6).toPrecision(3)} M/s` : hz >= 1e3 ? `${(hz / 1e3).toPrecision(3)} k/s` : `${hz.toPrecision(3)} /s`;

function showLight(light) {
  const meter = at("meter"), share = light ? light.brightest_hz / light.limit_hz : 0, peak = light ? light.run_brightest_hz / light.limit_hz : 0;
  meter.dataset.level = peak > 1 ? "bad" : peak > 0.5 ? "warn" : "good";
  meter.setAttribute("aria-valuenow", String(Math.round(100 * share)));
  at("brightest").style.width = `${Math.min(100, 100 * share)}%`;
  at("mean").style.left = light ? `${Math.min(99, 100 * light.mean_hz / light.limit_hz)}%` : "0";
  put("share", light ? `${(100 * share).toPrecision(3)} % of the linear limit` : "no counts yet");
  const facts = light ? [["brightest now", rate(light.brightest_hz)], ["brightest of the run", rate(light.run_brightest_hz)], ["mean now", rate(light.mean_hz)], ["linear up to", rate(light.limit_hz)]] : [];
  at("light").replaceChildren(...facts.flatMap(([what, value]) => fact(what, value)));
}

const px = (value) => value === null ? "-" : `${value >= 0 ? "+" : "\u2212"}${Math.abs(value).toFixed(2)} px`;

const withSigma = (value, sigma) => sigma === null ? px(value) : `${px(value).replace(" px", "")} \u00b1 ${sigma.toFixed(2)} px`;

function showLive(live, scale) {
  put("x", withSigma(live.x_px, live.sigma_x_px));
  put("y", withSigma(live.y_px, live.sigma_y_px));
  put("mm", live.along_mm === null ? "" : `${live.along_mm.toFixed(3)} mm along the stage`);
  put("where", live.frames ? `frame ${live.frames}` : "");
  at("path").setAttribute("aria-label", live.x_px === null ? "No displacement yet" : `Displacement after ${live.frames} frames: x ${px(live.x_px)}, y ${px(live.y_px)}`);
  const words = image ? `Image of ${image.frames} frames, ${image.columns} by ${image.rows} pixels` : "No image yet";
  at("image").setAttribute("aria-label", words);
  at("field").setAttribute("aria-label", image ? `The object, displaced by x ${px(live.x_px)}, y ${px(live.y_px)}` : words);
  const side = image?.columns ?? state.plan?.image_size;
  at("bar").hidden = !side;
  if (side) {
    const length = scale ? step(side / scale, 4) : step(side, 4);
    at("bar").style.width = `${Math.round(at("image").clientWidth * length * (scale || 1) / side)}px`;
    put("barlabel", scale ? `${length} mm` : `${length} px`);
  }
  const now = performance.now(), shown = seen.painted_ms.filter((t) => now - t < 1000).length, delays = seen.delays_ms.slice(-100).sort((a, b) => a - b);
  const here = ["127.0.0.1", "localhost", "[::1]"].includes(location.hostname) && delays.length;
  put("rate", seen.images ? `${shown} images a second, ${seen.skipped + seen.dropped} skipped` + (here ? `, ${delays[Math.floor(0.95 * (delays.length - 1))].toFixed(0)} ms from send to paint (95 %)` : "") +
    (live.frames_dropped ? `, ${live.frames_dropped} frames dropped by the live analysis; the recording has them` : "") : "");
}

const made = new Map();
function lines(id, none, values, fill) {
  const key = JSON.stringify(values);
  if (made.get(id) === key) return;
  const list = at(id), before = JSON.parse(made.get(id) ?? "[]");
  made.set(id, key);
  at(none).hidden = values.length > 0;
  const kept = before.every((value, k) => JSON.stringify(value) === JSON.stringify(values[k])) ? before.length : 0;
  if (!kept) list.replaceChildren();
  list.append(...values.slice(kept).map((value) => { const item = document.createElement("li"); fill(item, value); return item; }));  // so that only what is new is read aloud
}

function badge(outcome) {
  const word = document.createElement("span");
  word.className = "outcome";
  word.dataset.outcome = outcome;
  word.textContent = outcome;
  return word;
}

function showDevice(item, { role, identity }) {
  const head = document.createElement("span");
  head.className = "role";
  head.textContent = role;
  const more = [["serial", identity.serial], ["firmware", identity.firmware], ["driver", identity.driver]].filter(([, value]) => value).map((pair) => pair.join(" "));
  item.append(head, [`${identity.vendor} ${identity.model}`, ...more].join(", "));
  if (identity.simulated) {
    const tag = document.createElement("span");
    tag.className = "tag";
    tag.textContent = "simulated";
    item.append(" ", tag);
  }
}

function controls(offers) {
  for (const button of document.querySelectorAll("[data-wish]")) button.disabled = !offers.includes(button.dataset.wish);
}

for (const button of document.querySelectorAll("[data-wish]")) {
  button.addEventListener("click", () => socket.send(JSON.stringify({ wish: button.dataset.wish })));
}
at("again").addEventListener("click", list);
const anew = () => { plotted_ms = fielded_ms = 0; pathDue = fieldDue = true; due(); redraw(); };
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", anew);
addEventListener("resize", anew);
connect();
