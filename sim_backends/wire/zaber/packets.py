"""Framing of the ASCII protocol on the device's side (sheet, section 2.1)."""

from dataclasses import dataclass

RESERVED = frozenset("/@#!:\\")
LONGEST = 80


def lrc(text: str) -> str:
    """Checksum of what stands after the type character: two's complement of the sum, two upper-case digits.

    >>> lrc("01 0 02 OK IDLE -- 10000")
    '4A'
    """
    return format(256 - sum(map(ord, text)) % 256 & 255, "02X")


@dataclass(frozen=True)
class Command:
    """What a host wants."""

    device: int
    axis: int
    message_id: int | None
    words: str
    checked: bool
    """Whether it carried a checksum."""


def understand(line: str) -> Command | None:
    """Take a line apart; None for what no device would act on: other types, wrong checksums, reserved characters."""
    if not line.startswith("/") or len(line) > LONGEST or not line.isascii():
        return None
    body, colon, digits = line[1:].partition(":")
    if (colon and digits.upper() != lrc(body)) or any(letter in RESERVED for letter in body):
        return None
    words = body.split()
    numbers: list[int] = []
    while words and words[0].isdigit() and len(numbers) < 3:
        numbers.append(int(words.pop(0)))
    device = numbers[0] if numbers else 0
    axis = numbers[1] if len(numbers) > 1 else 0
    message_id = numbers[2] if len(numbers) > 2 else None
    if message_id is not None and message_id > 99:
        return None
    return Command(device, axis, message_id, " ".join(words), bool(colon))
