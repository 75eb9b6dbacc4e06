"""Mistakes in the ``[scheme]`` table of each scheme are told with their line and a suggestion."""

from pathlib import Path

import pytest

from instrument.config import ConfigError
from instrument.plan import Plan


def _said(folder: Path, scheme: str, superpixel: int = 2) -> list[str]:
    path = folder / "plan.toml"
    path.write_text(f"frames = 10\nsuperpixel = {superpixel}\n[scheme]\n{scheme}\n")
    with pytest.raises(ConfigError) as caught:
        Plan.from_toml(path)
    return [str(problem).replace(f"{folder}/", "") for problem in caught.value.problems]


@pytest.mark.parametrize(
    ("scheme", "key", "meant"),
    [
        ("moment-hadamard", "upsamling", "upsampling"),
        ("moment-hadamard", "hadamard_oder", "hadamard_order"),
        ("hadamard", "shuffle_sed", "shuffle_seed"),
        ("fourier-3step", "fourier_cycle", "fourier_cycles"),
        ("fourier-hadamard", "fourier_cycle", "fourier_cycles"),
    ],
)
def test_an_unknown_key_is_told_with_the_nearest_one(tmp_path: Path, scheme: str, key: str, meant: str) -> None:
    (problem,) = _said(tmp_path, f'name = "{scheme}"\n{key} = 2')
    assert problem.startswith(f"plan.toml:5: scheme.{key}: saw an unknown key; expected one of ")
    assert problem.endswith(f"(did you mean {meant}?)")


@pytest.mark.parametrize(
    ("scheme", "key", "value"),
    [
        ("hadamard", "upsampling", "2"),
        ("hadamard", "fourier_cycles", "2"),
        ("moment-hadamard", "fourier_cycles", "2"),
        ("fourier-3step", "hadamard_order", '"tv"'),
        ("fourier-3step", "shuffle_seed", "1"),
    ],
)
def test_a_key_of_another_scheme_is_unknown(tmp_path: Path, scheme: str, key: str, value: str) -> None:
    (problem,) = _said(tmp_path, f'name = "{scheme}"\n{key} = {value}')
    assert problem.startswith(f"plan.toml:5: scheme.{key}: saw an unknown key")


@pytest.mark.parametrize(
    ("scheme", "line", "expected"),
    [
        ("moment-hadamard", "upsampling = 0", "scheme.upsampling: saw 0; expected greater than 0"),
        (
            "moment-hadamard",
            "upsampling = 3",
            "scheme.upsampling: saw 3; expected another value (scheme.upsampling is 3:",
        ),
        ("moment-hadamard", 'upsampling = "2"', 'scheme.upsampling: saw "2"; expected a whole number'),
        (
            "hadamard",
            'hadamard_order = "TV"',
            "scheme.hadamard_order: saw \"TV\"; expected 'tv', 'tv-isotropic', 'hyperbolic', ",
        ),
        ("hadamard", "shuffle_seed = -1", "scheme.shuffle_seed: saw -1; expected greater than or equal to 0"),
        ("fourier-3step", "fourier_cycles = 64", "scheme.fourier_cycles: saw 64; expected another value"),
        ("fourier-3step", "fourier_cycles = 0", "scheme.fourier_cycles: saw 0; expected greater than 0"),
    ],
)
def test_a_value_that_will_not_do_is_told(tmp_path: Path, scheme: str, line: str, expected: str) -> None:
    (problem,) = _said(tmp_path, f'name = "{scheme}"\n{line}')
    assert problem.startswith(f"plan.toml:5: {expected}")


def test_a_default_that_does_not_go_with_the_mirrors_is_told_at_the_scheme(tmp_path: Path) -> None:
    """One mirror a pixel has no room for the two samples of moment-hadamard."""
    (problem,) = _said(tmp_path, 'name = "moment-hadamard"', superpixel=1)
    assert "it must divide superpixel = 1, the mirrors a pixel side" in problem


def test_a_misspelt_scheme_is_told_with_the_nearest_one(tmp_path: Path) -> None:
    for misspelt, meant in (
        ("moment-hadamart", "moment-hadamard"),
        ("hadamar", "hadamard"),
        ("fourier-3-step", "fourier-3step"),
    ):
        (problem,) = _said(tmp_path, f'name = "{misspelt}"')
        assert problem.startswith(f"plan.toml:4: scheme.name: saw '{misspelt}', a scheme plug-in that no installed")
        assert f"did you mean '{meant}'?" in problem
