"""What was probably meant."""

import pytest

from instrument.config.suggest import suggest_key, suggest_value, unit_of

KNOWN = ["start_mm", "velocity_mm_s", "acceleration_mm_s2", "dead_time_s", "kind"]


@pytest.mark.parametrize(
    ("name", "stem", "unit"),
    [
        ("velocity_mm_s", "velocity", "mm/s"),
        ("acceleration_mm_s2", "acceleration", "mm/s2"),
        ("pattern_rate_hz", "pattern_rate", "Hz"),
        ("frequency_per_px", "frequency", "1/px"),
        ("image_size", "image_size", ""),
        ("s", "s", ""),
    ],
)
def test_a_name_ends_on_its_unit(name: str, stem: str, unit: str) -> None:
    assert unit_of(name) == (stem, unit)


@pytest.mark.parametrize(
    ("key", "suggestion"),
    [
        ("velocity", "did you mean velocity_mm_s, in mm/s?"),
        ("velocity_um_s", "did you mean velocity_mm_s, in mm/s? Convert the value from um/s"),
        ("start_um", "did you mean start_mm, in mm? Convert the value from um"),
        ("dead_time_ns", "did you mean dead_time_s, in s? Convert the value from ns"),
        ("velcity_mm_s", "did you mean velocity_mm_s?"),
        ("Kind", "did you mean kind?"),
        ("voltage", ""),
    ],
)
def test_a_slip_is_answered_with_the_key_and_its_unit(key: str, suggestion: str) -> None:
    assert suggest_key(key, KNOWN) == suggestion


def test_a_value_is_matched_without_regard_to_case() -> None:
    assert suggest_value("CRUISE", ["cruise", "from-rest"]) == "did you mean 'cruise'?"
    assert suggest_value("hover", ["cruise", "from-rest"]) == ""
