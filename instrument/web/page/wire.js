// The binary frames, as instrument/web/frames.py writes them.
export const VERSION = 2;
// Floats a point of the path: seconds, x, y, and the standard uncertainty of both.
export const POINT = 5;
const HEAD = 32;

export function read(buffer) {
  const view = new DataView(buffer);
  if (buffer.byteLength < HEAD || view.getUint32(0, false) !== 0x4b4e5058) throw new Error("no frame of Kinopix");
  const head = {
    version: view.getUint16(4, true), kind: view.getUint16(6, true), sequence: view.getUint32(8, true),
    skipped: view.getUint32(12, true), sent_s: view.getFloat64(16, true), made_s: view.getFloat64(24, true),
  };
  if (head.version !== VERSION) throw new Error("a frame of another version: load the page anew");
  if (head.kind === 1) {
    const columns = view.getUint16(HEAD, true), rows = view.getUint16(HEAD + 2, true);
    return { ...head, columns, rows, frames: view.getUint32(HEAD + 4, true), white: view.getFloat32(HEAD + 8, true),
      pixels: new Uint8Array(buffer, HEAD + 12, columns * rows) };
  }
  const count = (buffer.byteLength - HEAD - 4) / (4 * POINT);
  return { ...head, first: view.getUint32(HEAD, true), points: new Float32Array(buffer.slice(HEAD + 4), 0, POINT * count) };
}
