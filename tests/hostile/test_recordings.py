"""Whatever finite values a recording holds, its analysis gives an answer or says in words why there is none."""

from dataclasses import replace

import numpy as np
import pytest

from instrument.analysis import analyse
from instrument.recording import Recording
from instrument.session import Instrument
from protocols import InputError
from tests.hostile.recordings import KINDS, spoiled
from tests.support.benches import SMALL, bench_toml


@pytest.fixture(scope="module", params=[16, pytest.param(32, marks=pytest.mark.thorough)])
def recording(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """A good run of 120 frames."""
    folder = tmp_path_factory.mktemp("recordings")
    plan = SMALL.model_copy(update={"frames": 120, "image_size": int(request.param)})
    bench = bench_toml(folder, 'noise = { kind = "poisson", peak_counts = 500.0, seed = 3 }')
    with Instrument.from_toml(bench) as instrument:
        return instrument.run(plan, folder / "run.h5")


@pytest.mark.parametrize(
    ("seed", "draws"), [(0, 2), *(pytest.param(seed, 4, marks=pytest.mark.thorough) for seed in (0, 1))]
)
@pytest.mark.parametrize("kind", KINDS)
def test_finite_values_give_an_analysis_or_a_cause(recording: Recording, kind: str, seed: int, draws: int) -> None:
    random = np.random.default_rng([seed, KINDS.index(kind)])
    for _ in range(draws):
        strange = spoiled(recording, kind, random)
        assert answered(strange), kind


def answered(recording: Recording) -> bool:
    try:
        analysis = analyse(recording)
    except InputError as error:
        return len(error.saw) > 10 and len(error.remedy) > 10
    return analysis.image is not None and bool(np.isfinite(analysis.image).all())


def refusal(recording: Recording) -> str:
    with pytest.raises(InputError) as caught:
        analyse(recording)
    return str(caught.value)


def test_values_that_never_change_are_called_so(recording: Recording) -> None:
    constant = replace(recording, values=np.full_like(recording.values, 7))
    assert "a signal without variation: all 120 frames have the same values, such as 7" in refusal(constant)


def test_exchanged_pairs_are_called_so_and_mended(recording: Recording) -> None:
    figures = analyse(replace(recording, values=recording.values[:, [0, 1, 2, 3, 5, 4]])).figures
    assert "the all-on pattern gives H+/S = 0.00: H- comes first" in figures.doubts[0]
    assert figures.psnr_db == analyse(recording).figures.psnr_db


@pytest.mark.parametrize("factor", [1e200, 1e-200])
def test_values_beyond_all_measure_are_called_so(recording: Recording, factor: float) -> None:
    assert "values up to" in refusal(replace(recording, values=recording.values * factor))


def test_a_good_run_is_not_refused(recording: Recording) -> None:
    assert analyse(recording).image is not None
