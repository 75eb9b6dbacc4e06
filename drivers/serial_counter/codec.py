"""Lines of the protocol: words, and a CRC-8."""

from typing import Final

LONGEST: Final = 64
"""Bytes of the longest line."""

_POLYNOMIAL: Final = 0x07


def crc8(data: bytes) -> int:
    """Give the CRC-8 of ``data``: polynomial 0x07, start 0, nothing reflected.

    >>> hex(crc8(b"123456789"))
    '0xf4'
    """
    crc = 0
    for byte in data:
        crc = _TABLE[crc ^ byte]
    return crc


def _table() -> bytes:
    table = bytearray()
    for value in range(256):
        crc = value
        for _ in range(8):
            crc = (crc << 1) ^ _POLYNOMIAL if crc & 0x80 else crc << 1
        table.append(crc & 0xFF)
    return bytes(table)


_TABLE: Final = _table()


def line(*words: object) -> bytes:
    r"""Give the bytes of a line.

    >>> line("arm", 2)
    b'arm,2*48\n'
    """
    text = ",".join(map(str, words)).encode("ascii")
    return b"%s*%02X\n" % (text, crc8(text))


def words_of(data: bytes) -> list[str] | None:
    """Give the words of a line without its end; None where its check sum is wrong or missing.

    >>> words_of(b"0,37,6250*6C")
    ['0', '37', '6250']
    """
    text, star, digits = data.rpartition(b"*")
    if not star or len(data) > LONGEST or digits != b"%02X" % crc8(text) or not text.isascii():
        return None
    return text.decode("ascii").split(",")


def bin_of(words: list[str]) -> tuple[int, int, int] | None:
    """Give index, count and ticks of a bin; None where the words are something else.

    >>> bin_of(["0", "37", "6250"])
    (0, 37, 6250)
    """
    if len(words) != 3 or not all(word.isdigit() for word in words):
        return None
    index, count, ticks = map(int, words)
    return (index, count, ticks) if max(count, ticks) < 2**32 else None
