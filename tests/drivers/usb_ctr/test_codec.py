"""The bytes of the USB-CTR, as the fact sheet's table of requests gives them (section 5.2)."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.usb_ctr import codec
from drivers.usb_ctr.codec import Request, Scan

ONE = Scan((0,))


def test_a_counter_is_set_by_five_bytes_mode_options_gate_output_debounce() -> None:
    request = codec.count_and_clear(2, debounce_code=16)
    assert (request.command, request.value, request.index) == (0x18, 0, 2)
    assert request.data == bytes.fromhex("00 01 00 00 10")


def test_falling_edges_are_option_bit_4() -> None:
    assert codec.count_and_clear(0, debounce_code=0, falling=True).data == bytes.fromhex("00 11 00 00 00")


def test_the_scan_list_is_33_bytes_and_its_last_element_is_the_index() -> None:
    request = codec.scan_config(Scan((3,)))
    assert (request.command, request.index) == (0x20, 0)
    assert request.data == bytes.fromhex("03") + bytes(32)


def test_a_wide_counter_takes_two_elements_that_name_its_16_bit_banks() -> None:
    request = codec.scan_config(Scan((1, 2), words=2))
    assert request.index == 3
    assert request.data == bytes.fromhex("01 09 02 0a") + bytes(29)


def test_scan_start_is_14_bytes_endless_on_the_external_clock_one_scan_a_packet() -> None:
    request = codec.scan_start(ONE)
    assert request.command == 0x21
    assert request.data == bytes.fromhex("00000000 00000000 00000000 00 00")


def test_a_paced_finite_scan_names_its_samples_and_9599_for_10_khz() -> None:
    request = codec.scan_start(Scan((0, 1)), samples=100, pacer_period=9599)
    assert request.data == bytes.fromhex("64000000 00000000 7f250000 01 00")


def test_stop_clear_and_flush_5_are_the_requests_of_the_end() -> None:
    assert [(r.command, r.value, r.data) for r in (codec.STOP_SCAN, codec.CLEAR_FIFO, codec.flush_bulk())] == [
        (0x22, 0, b""),
        (0x23, 0, b""),
        (0x24, 5, b""),
    ]


def test_a_timer_takes_period_width_count_delay_and_a_control_bit() -> None:
    parameters = codec.timer_parameters(1, period=9)
    assert (parameters.command, parameters.index) == (0x2D, 1)
    assert parameters.data == bytes.fromhex("09000000 00000000 00000000 00000000")
    assert codec.timer_control(1, on=True) == Request(codec.Command.TIMER_CONTROL, value=1, index=1)
    assert codec.timer_control(1, on=False).value == 0


def test_the_fpga_is_unlocked_by_ad_and_fed_in_blocks_of_64() -> None:
    requests = codec.load_fpga(bytes(range(130)))
    assert [(r.command, len(r.data)) for r in requests] == [(0x50, 1), (0x51, 64), (0x51, 64), (0x51, 2), (0x51, 2)]
    assert requests[0].data == b"\xad"
    assert b"".join(r.data for r in requests[1:-1]) == bytes(range(130))
    assert requests[-1].data == b"\0\0"


@pytest.mark.parametrize(
    ("answer", "true_bits"),
    [
        ("0000", set[str]()),
        ("0200", set[str]()),
        ("0400", {"overrun"}),
        ("0001", {"fpga_configured"}),
        ("0002", set[str]()),
        ("0601", {"overrun", "fpga_configured"}),
    ],
)
def test_status_bits_are_little_endian(answer: str, true_bits: set[str]) -> None:
    status = codec.parse_status(bytes.fromhex(answer))
    bits = {"overrun", "fpga_configured"}
    assert {name for name in bits if getattr(status, name)} == true_bits


def test_scan_done_is_the_bit_that_the_settings_name() -> None:
    assert codec.parse_status(bytes.fromhex("4000")).scan_done(0x40)
    assert not codec.parse_status(bytes.fromhex("4000")).scan_done(0x20)
    assert codec.parse_status(bytes.fromhex("2000")).scan_done(0x20)


def test_serial_and_fpga_version_are_ascii_and_bcd() -> None:
    assert codec.parse_serial(b"01AB23CD") == "01AB23CD"
    assert codec.parse_fpga_version(bytes.fromhex("0201")) == "01.02"


@pytest.mark.parametrize("answer", [b"", b"1234567", b"123456789", b"1234567\xff"])
def test_a_serial_number_of_another_shape_is_refused(answer: bytes) -> None:
    with pytest.raises(codec.BadAnswer, match="eight ASCII bytes"):
        codec.parse_serial(answer)


def test_samples_are_16_bit_words_in_list_order() -> None:
    counts, rest = codec.decode(Scan((0, 1)), bytes.fromhex("0500 e001 0000 e101"))
    assert counts.tolist() == [[5, 480], [0, 481]]
    assert rest == b""


def test_a_wide_sample_is_its_low_word_then_its_high_word() -> None:
    assert codec.decode(Scan((0,), words=2), bytes.fromhex("0100 0200"))[0].tolist() == [[0x20001]]


@given(st.binary(max_size=60), st.sampled_from([(1, 1), (1, 2), (2, 1), (2, 2), (3, 1)]))
def test_any_bytes_decode_to_whole_samples_and_a_rest_and_nothing_is_made_up(
    data: bytes, shape: tuple[int, int]
) -> None:
    counters, words = shape
    scan = Scan(tuple(range(counters)), words)
    counts, rest = codec.decode(scan, data)
    assert counts.shape == (len(data) // scan.bytes_per_scan, counters)
    again = b"".join(int(c).to_bytes(2 * words, "little") for c in counts.ravel())
    assert again + rest == data


@given(st.binary(max_size=80), st.lists(st.integers(0, 40), max_size=5))
def test_data_cut_at_any_sample_decode_to_the_same_counts(data: bytes, cuts: list[int]) -> None:
    data = data[: len(data) // 2 * 2]
    at = [0, *sorted(min(2 * cut, len(data)) for cut in cuts), len(data)]
    parts = [codec.decode(ONE, data[a:b])[0] for a, b in itertools.pairwise(at)]
    assert np.array_equal(np.concatenate(parts), codec.decode(ONE, data)[0])


@given(st.binary(max_size=12))
def test_answers_of_any_bytes_are_parsed_or_refused(answer: bytes) -> None:
    for parse in (codec.parse_status, codec.parse_serial, codec.parse_fpga_version):
        try:
            parse(answer)
        except codec.BadAnswer:
            assert len(answer) != 2 or parse is codec.parse_serial
