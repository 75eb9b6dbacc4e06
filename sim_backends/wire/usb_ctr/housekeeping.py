"""Requests that have nothing to do with counting: digital lines, memory, serial number, LED, trigger."""

from sim_backends.wire.usb_ctr.requests import Read, Stall, Write, exactly, number

UNLOCK = b"\xad"
_USER_MEMORY = range(0x7000, 0x8000)


class Housekeeping:
    """Registers that are only kept, and the EEPROM. The trigger configuration is kept and has no effect."""

    def __init__(self, serial_number: str) -> None:
        self.blinks = 0
        self._tristate, self._latch, self._trigger = 0xFF, 0, 0
        self._memory = bytearray(_USER_MEMORY.stop)
        self._address = 0
        self._unlocked = False
        self._serial = serial_number.encode()
        self.writes: dict[int, Write] = {
            0x00: self._set_tristate,
            0x02: self._set_latch,
            0x30: self._write_memory,
            0x31: self._set_address,
            0x32: self._unlock,
            0x41: self._blink,
            0x43: self._set_trigger,
            0x48: self._set_serial,
        }
        self.reads: dict[int, Read] = {
            0x00: lambda _value, _index, _size: self._tristate.to_bytes(2, "little"),
            0x01: lambda _value, _index, _size: (self._latch & ~self._tristate & 0xFF).to_bytes(2, "little"),
            0x02: lambda _value, _index, _size: self._latch.to_bytes(2, "little"),
            0x30: self._read_memory,
            0x31: lambda _value, _index, _size: self._address.to_bytes(2, "little"),
            0x43: lambda _value, _index, _size: bytes([self._trigger]),
            0x48: lambda _value, _index, _size: self._serial,
        }

    def _set_tristate(self, value: int, _index: int, _data: bytes) -> None:
        self._tristate = value & 0xFF

    def _set_latch(self, value: int, _index: int, _data: bytes) -> None:
        self._latch = value & 0xFF

    def _set_address(self, _value: int, _index: int, data: bytes) -> None:
        self._address = number(data, 2)

    def _unlock(self, _value: int, _index: int, data: bytes) -> None:
        self._unlocked = data == UNLOCK

    def _write_memory(self, _value: int, _index: int, data: bytes) -> None:
        end = self._address + len(data)
        if end > len(self._memory) or not (self._unlocked or self._address in _USER_MEMORY):
            raise Stall
        self._memory[self._address : end] = data
        self._address = end

    def _read_memory(self, _value: int, _index: int, size: int) -> bytes:
        data = bytes(self._memory[self._address : self._address + size])
        self._address += len(data)
        return data

    def _blink(self, _value: int, _index: int, data: bytes) -> None:
        self.blinks += number(data, 1)

    def _set_trigger(self, _value: int, _index: int, data: bytes) -> None:
        self._trigger = number(data, 1)

    def _set_serial(self, _value: int, _index: int, data: bytes) -> None:
        self._serial = exactly(data, 8)
