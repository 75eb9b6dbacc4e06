"""The functions of alp.h on an emulated board (dlp7000.md 3.2).

Each refuses by raising ``Refused``; the library turns that into a return code.
"""

import ctypes
import math
import threading
from collections import Counter

from sim_backends.bench import OpticalBench
from sim_backends.wire.alp.codes import DMD_POWER_FLOAT, INVALID_ID, Code, Dev, Proj, Refused, Seq, State, require
from sim_backends.wire.alp.device import Device
from sim_backends.wire.alp.owner import Owner
from sim_backends.wire.alp.projector import Projector
from sim_backends.wire.alp.sequence import Sequence
from sim_backends.wire.alp.settings import AlpEmulatorSettings, CallFault
from sim_backends.wire.alp.timing import Asked

_CHUNK_S = 0.05
"""AlpSeqPut looks this often whether it was halted."""

_ABORTS = (Proj.ABORT_SEQUENCE, Proj.ABORT_FRAME, Proj.ABORT_ASYNC)


def _store(address: int | None, value: int) -> None:
    """Write a 32-bit integer to the caller's memory."""
    require(bool(address), Code.ADDR_INVALID)
    ctypes.c_uint32.from_address(address or 0).value = value


class EmulatedAlpBoard:
    """One V-7000 and its library. Calls may come from any thread; AlpSeqPut and AlpProjWait let others through."""

    def __init__(self, settings: AlpEmulatorSettings, bench: OpticalBench) -> None:
        """Plug the board in and switch it on."""
        self.settings = settings
        self.bench = bench
        self._lock = threading.RLock()
        self._calls: Counter[str] = Counter()
        self._dead: int | None = None
        self._ids = 0x1000
        self._device_id: int | None = None
        self._owner = Owner(settings.owner_file)
        self._settled_s = -math.inf
        self._halts = 0
        self._power_up()

    def _power_up(self) -> None:
        self._device = Device(self.settings)
        self._projector = Projector(self.settings, self.bench, self._device.geometry)
        self._sequences: dict[int, Sequence] = {}
        self._loading: list[Sequence] = []

    def begin_call(self, function: str) -> CallFault | None:
        """Count a call and give the fault that strikes it.

        Raises:
            Refused: the board is gone, or this call is to be refused.
        """
        with self._lock:
            self._calls[function] += 1
            nth = self._calls[function]
            for fault in self.settings.faults:
                if isinstance(fault, CallFault) and (fault.function, fault.nth) == (function, nth):
                    self._strike(fault)
                    return fault
            if self._dead is not None:
                raise Refused(self._dead)
            self._projector.settle()
        return None

    def _strike(self, fault: CallFault) -> None:
        if fault.kind == "halt-during-put":
            return
        if fault.kind in ("unplug", "power-loss"):
            self._dead = Code.DEVICE_REMOVED if fault.kind == "unplug" else Code.NOT_ONLINE
            self._projector.halt()
            raise Refused(self._dead)
        codes = {"other-owner": int(Code.NOT_READY), "memory-full": int(Code.MEMORY_FULL)}
        raise Refused(codes.get(fault.kind, fault.code))

    # Device

    def dev_alloc(self, number: int, flags: int, device: int | None) -> None:
        """AlpDevAlloc: by serial number, or 0 for the first found."""
        require(bool(device), Code.ADDR_INVALID)
        _store(device, INVALID_ID)
        require(number in (0, self.settings.serial_number), Code.NOT_ONLINE)
        require(self._device_id is None and not self._owner.held, Code.NOT_READY)
        require(self.bench.clock.now_s() >= self._settled_s, self.settings.reallocation_code)
        require(flags == 0)
        self._power_up()
        self._owner.take()
        self._device_id = self._new_id()
        _store(device, self._device_id)

    def _new_id(self) -> int:
        self._ids += 0x11
        return self._ids

    def _check(self, device: int) -> None:
        require(device == self._device_id, self.settings.unknown_device_code)

    def _sequence(self, device: int, sequence: int) -> Sequence:
        self._check(device)
        require(sequence in self._sequences, self.settings.unknown_sequence_code)
        return self._sequences[sequence]

    @property
    def _state(self) -> State:
        busy = self._projector.running is not None or self._loading
        return State.BUSY if busy else self._device.state

    def dev_halt(self, device: int) -> None:
        """AlpDevHalt: cancels the display and aborts a transfer."""
        self._check(device)
        self._halts += 1
        self._projector.halt()
        self._device.state = State.IDLE

    def dev_free(self, device: int) -> None:
        """AlpDevFree: frees the sequences too."""
        self._check(device)
        settled = (State.IDLE,) if self.settings.free_needs_halt else (State.IDLE, State.READY)
        require(self._state in settled, Code.NOT_IDLE)
        self._device_id = None
        self._owner.release()
        self._settled_s = self.bench.clock.now_s() + self.settings.reallocation_s
        self._projector.halt()
        self._sequences.clear()

    def dev_control(self, device: int, kind: int, value: int) -> None:
        """AlpDevControl."""
        self._check(device)
        self._device.control(kind, value)
        if kind == Dev.DMD_MODE and value == DMD_POWER_FLOAT:
            self._projector.halt()

    def dev_control_ex(self, device: int, kind: int, struct: int | None) -> None:
        """AlpDevControlEx: the gates of the dynamic synch outputs, to which nothing is connected here."""
        self._check(device)
        require(kind in (Dev.DYN_SYNCH_OUT1_GATE, Dev.DYN_SYNCH_OUT2_GATE, Dev.DYN_SYNCH_OUT3_GATE))
        require(bool(struct), Code.ADDR_INVALID)
        period, polarity = ctypes.string_at(struct or 0, 2)
        require(period <= 16 and polarity <= 1)

    def dev_inquire(self, device: int, kind: int, value: int | None) -> None:
        """AlpDevInquire."""
        self._check(device)
        _store(value, self._device.inquire(kind, self._state))

    # Sequences

    def seq_alloc(self, device: int, bit_planes: int, pictures: int, sequence: int | None) -> None:
        """AlpSeqAlloc: one contiguous block of bit_planes * pictures binary frames."""
        self._check(device)
        require(bool(sequence), Code.ADDR_INVALID)
        _store(sequence, INVALID_ID)
        require(1 <= bit_planes <= 8 and pictures >= 1)
        start = self._device.memory.allocate(bit_planes * pictures)
        if start is None:
            raise Refused(Code.MEMORY_FULL)
        number = self._new_id()
        self._sequences[number] = Sequence(self.settings, self._device.geometry, bit_planes, pictures, start)
        _store(sequence, number)

    def seq_free(self, device: int, sequence: int) -> None:
        """AlpSeqFree."""
        freed = self._sequence(device, sequence)
        busy = self._projector.uses(freed) or any(freed is loading for loading in self._loading)
        require(not busy, Code.SEQ_IN_USE)
        self._device.memory.release(freed.memory_at)
        del self._sequences[sequence]

    def seq_control(self, device: int, sequence: int, kind: int, value: int) -> None:
        """AlpSeqControl."""
        self._sequence(device, sequence).control(kind, value, self._projector.table)

    def seq_timing(self, device: int, sequence: int, *times_us: int) -> None:
        """AlpSeqTiming: illuminate, picture, synch delay, synch pulse width, trigger-in delay."""
        self._sequence(device, sequence).set_timing(Asked(*times_us))

    def seq_inquire(self, device: int, sequence: int, kind: int, value: int | None) -> None:
        """AlpSeqInquire."""
        _store(value, self._sequence(device, sequence).inquire(kind))

    def seq_put(
        self, device: int, sequence: int, offset: int, load: int, data: int | None, *, fault: CallFault | None = None
    ) -> None:
        """AlpSeqPut: reads exactly the bytes of the data format, and takes the time of the USB line."""
        with self._lock:
            target = self._sequence(device, sequence)
            if load == 0:
                require(offset == 0)
                load = target.units
            require(offset >= 0 and load > 0 and offset + load <= target.units)
            require(bool(data), Code.ADDR_INVALID)
            require(target.controls[Seq.PUT_LOCK] != 0 or not self._projector.uses(target), Code.SEQ_IN_USE)
            self._loading.append(target)
            halts = self._halts
        try:
            self._transfer(target, offset, load, data or 0, halts, aborted=fault is not None)
        finally:
            with self._lock:
                self._loading.remove(target)

    def seq_put_ex(self, device: int, sequence: int, struct: int | None, data: int | None) -> None:
        """AlpSeqPutEx: ``tAlpLinePut`` (dlp7000.md 3.7): some lines of each picture of a stretch, in the data format."""
        require(bool(struct) and bool(data), Code.ADDR_INVALID)
        mode, offset, load, line, lines = (ctypes.c_int32 * 5).from_address(struct or 0)
        with self._lock:
            target = self._sequence(device, sequence)
            rows = target.geometry.rows
            load = load or target.units - offset
            lines = lines or rows - line
            require(mode == 1 and offset >= 0 and load > 0 and offset + load <= target.units)
            require(line >= 0 and lines > 0 and line + lines <= rows)
            require(target.controls[Seq.PUT_LOCK] != 0 or not self._projector.uses(target), Code.SEQ_IN_USE)
        line_bytes = target.put_lines(offset, load, (line, lines), data or 0)
        self.bench.clock.sleep_s(load * lines * line_bytes / self.settings.usb_bytes_per_s)

    def _transfer(self, target: Sequence, offset: int, load: int, data: int, halts: int, *, aborted: bool) -> None:
        data_format = target.controls[Seq.DATA_FORMAT]
        unit_bytes = target.geometry.unit_bytes(data_format)
        unit_s = unit_bytes / self.settings.usb_bytes_per_s
        planes_a_unit = len(target.planes) // target.units
        owed_s = 0.0
        for unit in range(load):
            if self._halts != halts or (aborted and 2 * unit >= load):
                self.bench.clock.sleep_s(owed_s)
                self._device.state = State.IDLE
                raise Refused(Code.HALTED)
            body = ctypes.string_at(data + unit * unit_bytes, unit_bytes)
            first = (offset + unit) * planes_a_unit
            planes = target.geometry.planes_of(body, data_format, planes_a_unit)
            target.planes[first : first + planes_a_unit] = planes
            owed_s += unit_s
            if owed_s >= _CHUNK_S:
                self.bench.clock.sleep_s(owed_s)
                owed_s = 0.0
        self.bench.clock.sleep_s(owed_s)

    # Projection

    def proj_start(self, device: int, sequence: int, *, endless: bool = False) -> None:
        """AlpProjStart: returns at once."""
        shown = self._sequence(device, sequence)
        require(self._device.controls[Dev.DMD_MODE] != DMD_POWER_FLOAT, Code.CONFIG_MISMATCH)
        polarity = self._device.controls[Dev.SYNCH_POLARITY]
        self._projector.start(sequence, shown, polarity, endless=endless)
        self._device.state = State.READY

    def proj_start_cont(self, device: int, sequence: int) -> None:
        """AlpProjStartCont."""
        self.proj_start(device, sequence, endless=True)

    def proj_halt(self, device: int) -> None:
        """AlpProjHalt: a request; the running iteration plays to its end."""
        self._check(device)
        self._projector.request_halt()

    def proj_wait(self, device: int) -> None:
        """AlpProjWait: blocks, on the bench's clock."""
        self._check(device)
        self._projector.wait()

    def proj_control(self, device: int, kind: int, value: int) -> None:
        """AlpProjControl: only while idle, but for the controls that are meant for a running projection."""
        self._check(device)
        projector = self._projector
        if kind in _ABORTS:
            require(value == 0 or kind != Proj.ABORT_ASYNC)
            projector.abort(kind)
            return
        if kind == Proj.RESET_QUEUE:
            require(value == 0)
            projector.forget_waiting()
            return
        require(projector.running is None, Code.NOT_IDLE)
        ranges = {
            Proj.MODE: (2301, 2302),
            Proj.QUEUE_MODE: (0, 1),
            Proj.WAIT_UNTIL: (0, 1),
            Proj.STEP: (0,),
        }
        require(kind in projector.controls and value in ranges.get(Proj(kind), (value,)))
        projector.controls[kind] = value

    def proj_control_ex(self, device: int, kind: int, struct: int | None) -> None:
        """AlpProjControlEx: the frame look-up table."""
        self._check(device)
        require(kind in (Proj.FLUT_WRITE_9BIT, Proj.FLUT_WRITE_18BIT))
        require(self._projector.running is None, Code.NOT_IDLE)
        self._projector.table.write_struct(kind, struct or 0)

    def proj_inquire(self, device: int, kind: int, value: int | None) -> None:
        """AlpProjInquire; it has no sequence argument."""
        self._check(device)
        _store(value, self._projector.inquire(kind))

    def proj_inquire_ex(self, device: int, kind: int, struct: int | None) -> None:
        """AlpProjInquireEx: tAlpProjProgress."""
        self._check(device)
        require(kind == Proj.PROGRESS)
        require(bool(struct), Code.ADDR_INVALID)
        words = (ctypes.c_uint32 * 9).from_address(struct or 0)
        words[:] = list(self._projector.progress())

    def locked(self) -> threading.RLock:
        """Give the lock that every call but the two long ones holds."""
        return self._lock
