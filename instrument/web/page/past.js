// Past recordings, and the dialog for one of them.
import { drawCurves } from "./draw.js";
import { put, fact } from "./page.js";

const at = (id) => document.getElementById(id);
let shown = null;

export async function list() {
  const answer = await fetch("/api/recordings").catch(() => null);
  if (!answer?.ok) return;
  const { folder, recordings } = await answer.json();
  at("past").hidden = folder === null;
  put("folder", folder ?? "");
  at("norecordings").hidden = recordings.length > 0;
  at("recordings").replaceChildren(...recordings.map(card));
}

function card(recording) {
  const item = document.createElement("li"), button = document.createElement("button");
  button.type = "button";
  button.addEventListener("click", () => open(recording.name));
  const first = recording.pictures.find((name) => name === "summary") ?? recording.pictures[0];
  if (first) {
    const picture = new Image();
    picture.src = source(recording.name, first);
    picture.alt = "";
    picture.loading = "lazy";
    button.append(picture);
  } else button.append(text("span", recording.error ? "cannot be read" : recording.analysed ? "no pictures" : "not analysed yet", "nothing"));
  const lines = document.createElement("span");
  lines.className = "text";
  lines.append(text("strong", recording.name), text("span", said(recording), "quiet"));
  button.append(lines);
  item.append(button);
  return item;
}

const said = (r) => r.error ? r.error : r.unread ? "read when the run is over" :
  [when(r.recorded), `${r.frames} frames`, r.state === "complete" ? r.verdict ?? "not audited" : r.state].filter(Boolean).join(", ");
const when = (iso) => iso ? new Date(iso).toLocaleString([], { dateStyle: "medium", timeStyle: "short" }) : "";
const source = (name, picture) => `/api/recordings/${encodeURIComponent(name)}/${picture}.png`;

function text(tag, words, kind = "") {
  const element = document.createElement(tag);
  element.textContent = words;
  if (kind) element.className = kind;
  return element;
}

async function open(name) {
  const answer = await fetch(`/api/recordings/${encodeURIComponent(name)}`).catch(() => null);
  if (!answer) return;
  const found = await answer.json();
  put("one-name", name);
  const rows = [
    ["about", found.about], ["recorded", when(found.recorded)], ["plan", found.plan], ["frames", found.frames === undefined ? null : `${found.frames}, ${found.frames_masked ?? "?"} masked`],
    ["state", found.interrupted ? `${found.state}: ${found.interrupted}` : found.state], ["timing", found.verdict], ["devices", found.devices?.join("; ")],
    ["analysed", found.analysed === undefined ? null : found.analysed ? when(found.analysed) : `not yet: kinopix analyse ${name}`],
    ["travel", found.travel_px ? `${found.travel_px.map((v) => v.toFixed(2)).join(", ")} px` : null],
    ["stated uncertainty", found.sigma_px == null ? null : `${found.sigma_px.toFixed(3)} px (median, one sigma)`],
    ["PSNR", found.psnr_db == null ? null : `${found.psnr_db.toFixed(1)} dB`],
    ...(found.notes ?? []).map((note) => ["note", note]), ...(found.doubts ?? []).map((doubt) => ["doubt", doubt]), ["error", found.error],
  ];
  at("one-facts").replaceChildren(...rows.filter(([, value]) => value).flatMap(([what, value]) => fact(what, value)));
  shown = found.path ?? null;
  at("one-path").hidden = !shown;
  at("one-band").hidden = !shown?.sigma_px;
  at("one-pictures").replaceChildren(...(found.pictures ?? []).map((picture) => {
    const image = new Image();
    image.src = source(name, picture);
    image.alt = `${picture} of ${name}`;
    image.loading = "lazy";
    return image;
  }));
  at("one").showModal();
  redraw();
}

export function redraw() {
  if (!shown || !at("one").open) return;
  const along = (rows, axis) => rows ? rows.map((row) => row[axis]) : null;
  at("one-path").setAttribute("aria-label", `Displacement over ${shown.time_s.at(-1)?.toFixed(2)} s`);
  drawCurves(at("one-path"), { time: shown.time_s, pxPerMm: shown.px_per_mm, lines: [
    { values: along(shown.px, 0), sigma: along(shown.sigma_px, 0), colour: "--x", width: 4 },
    { values: along(shown.px, 1), sigma: along(shown.sigma_px, 1), colour: "--y", width: 2 } ] });
}
