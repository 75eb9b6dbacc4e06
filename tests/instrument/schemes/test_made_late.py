"""A scheme makes its patterns when they are asked for: a check of a field that is too large makes none."""

import pytest

from instrument.plan import Plan
from instrument.schemes import fourier_hadamard, scheme_of


def test_to_look_whether_something_is_a_scheme_makes_no_pattern(monkeypatch: pytest.MonkeyPatch) -> None:
    def made(*arguments: object) -> object:
        raise AssertionError(f"a pattern was made: {arguments}")

    monkeypatch.setattr("instrument.patterns.fourier.floyd_steinberg", made)
    scheme = scheme_of(Plan(frames=3, image_size=2048, superpixel=1))
    assert len(scheme.columns) == 6
    assert isinstance(scheme, fourier_hadamard.FourierHadamard)
    with pytest.raises(AssertionError, match="a pattern was made"):
        _ = scheme.fixed_patterns
