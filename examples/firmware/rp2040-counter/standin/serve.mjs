// SPDX-License-Identifier: BSD-3-Clause
// counter.bin on an emulated RP2040: its UART is standard input and output. Once it is armed, N + 3 sync edges come, PERIOD cycles of
// 8 ns apart, with 7 k mod 50 pulses in bin k: node serve.mjs counter.bin N PERIOD
import { RP2040 } from 'rp2040js';
import fs from 'fs';
const mcu = new RP2040();
const bin = fs.readFileSync(process.argv[2]);
mcu.logger = { debug() {}, info() {}, warn() {}, error(c, m) { console.error(c, m); } };
mcu.flash.set(bin);
const view = new DataView(bin.buffer, bin.byteOffset);
mcu.core.SP = view.getUint32(0, true);
mcu.core.PC = view.getUint32(4, true) & ~1;
const pio = mcu.pio[0];
pio.run = () => {};
let out = '';
mcu.uart[0].onByte = (b) => { out += String.fromCharCode(b); };
let now = 0, events = [];       // [cycle, pin, value]
const clock = mcu.clock;
function advance(cycles) {
  for (let i = 0; i < cycles; i++) {
    now++;
    while (events.length && events[0][0] <= now) { const [, pin, v] = events.shift(); mcu.gpio[pin].setInputValue(v); }
    if (!pio.stopped) pio.step();
  }
  clock.tick(cycles * 8);
}
function run(cycles) { const end = now + cycles; while (now < end) advance(mcu.core.executeInstruction() || 1); }

const N = Number(process.argv[3]), period = Number(process.argv[4]);
process.stdin.on('data', (d) => { for (const b of d) mcu.uart[0].feedByte(b); });
process.stdin.on('end', () => process.exit());
function loop() {
  run(30000);
  if (out) {
    process.stdout.write(out);
    if (/armed,/.test(out)) {
      const ev = []; let t = now + 500000;
      for (let k = 0; k <= N + 2; k++) { ev.push([t, 3, true], [t + 200, 3, false]); for (let p = 0; p < (k * 7) % 50; p++) ev.push([t + 300 + 40 * p, 2, true], [t + 304 + 40 * p, 2, false]); t += period; }
      events = ev;
    }
    out = '';
  }
  setImmediate(loop);
}
loop();
