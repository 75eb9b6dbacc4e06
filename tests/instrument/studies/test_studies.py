"""The studies: motions, runs and processing, held against what can be worked out by hand."""

from collections.abc import Callable
from dataclasses import replace
from typing import TypeAlias, get_args

import numpy as np
import pytest

from instrument.choices import Reproduced, StudyName
from instrument.measurement import Measurement
from instrument.recording import Recording
from instrument.studies import (
    METRICS,
    STUDIES,
    Case,
    Outcome,
    Simulated,
    Spread,
    Study,
    Summary,
    accelerated,
    as_published,
    curve,
)
from instrument.studies.experiment import EXPERIMENT
from instrument.studies.motions import along_diagonal, circle
from instrument.studies.processing import own
from instrument.studies.reproduce import points_of
from instrument.studies.simulated import letters_beside, record
from instrument.tracking import track
from protocols import Floats, InputError
from tests.instrument.studies import tiny

SHORT = Simulated(part=0.06)
"""100 frames."""


@pytest.fixture(scope="module")
def short() -> Recording:
    return record(SHORT, seed=3)


@pytest.fixture(scope="module")
def published(short: Recording) -> Outcome:
    return as_published(short)


def at(path: Floats, index: int) -> object:
    return pytest.approx(path[index].tolist(), abs=1e-9)


def test_motions_of_the_simulation_begin_at_0_and_end_where_they_should() -> None:
    times = np.array([0.0, 0.25, 0.5])
    assert at(curve(0.5)(times), 0) == [0, 0]
    assert at(curve(0.5)(times), 1) == [33.0, 3.2 + 28.8]
    assert at(curve(0.5)(times), 2) == [66.0, 64.0]
    assert at(accelerated(0.5)(times), 0) == [0, 0]
    assert at(accelerated(0.5)(times), 1) == [66 * (1 / 3 + 1 / 12)] * 2
    assert at(accelerated(0.5)(times), 2) == [66.0, 66.0]


def test_motions_of_the_experiment_are_as_fast_as_its_stage() -> None:
    """25 mm/s for half a second is 12.5 mm, 90 px along the diagonal; 50 mm/s^2 add 6.25 mm, 45 px."""
    end = np.array([0.5])
    np.testing.assert_allclose(along_diagonal(25.0)(end), [[90 / np.sqrt(2)] * 2])
    np.testing.assert_allclose(along_diagonal(25.0, 50.0)(end), [[135 / np.sqrt(2)] * 2])
    two = circle(100.0)(np.array([0.0, 1e-4]))
    np.testing.assert_allclose(np.hypot(*(two[1] - two[0])), 720 * 1e-4, rtol=1e-3)
    quarter_s = np.pi / 2 * 30 / 720
    np.testing.assert_allclose(circle(100.0)(np.array([quarter_s])), [[30.0, 30.0]])


@pytest.mark.parametrize("study", STUDIES.values(), ids=list(STUDIES))
def test_the_object_of_every_study_stays_inside_the_field(study: Study) -> None:
    for case in study.cases:
        settings = case.settings
        path = settings.path(np.linspace(0, settings.plan.run_time_s, 500))
        low, high = path.min(axis=0), path.max(axis=0)
        left, top = settings.corner_px
        assert (low + np.array([left, top]) >= 0).all(), case.label
        size = np.array([round(0.78 * settings.height_px), settings.height_px])
        assert (high + np.array([left, top]) + size <= 128).all(), case.label


def test_the_command_offers_every_study_and_all_of_them() -> None:
    assert list(STUDIES) == list(get_args(StudyName))
    assert get_args(Reproduced) == (*get_args(StudyName), "all")
    for study in STUDIES.values():
        labels = [case.label for case in study.cases]
        assert len(set(labels)) == len(labels)
        assert {label for label, _ in study.paper} <= set(labels)
        assert {metric for _, metric in study.paper} <= set(METRICS)
    assert [point.name for point in points_of(STUDIES["dgi"], 2)][:2] == ["dgi: 20 %, seed 0", "dgi: 20 %, seed 1"]


def test_the_paper_has_1666_frames_or_4998_pairs() -> None:
    assert [Simulated(scheme=name).plan.frames for name in ("fourier-hadamard", "moment-hadamard", "hadamard")] == [
        1666,
        1666,
        4998,
    ]
    assert Simulated(part=0.1).plan.frames == 167
    assert Simulated(scheme="moment-hadamard", upsampling=4, superpixel=4).plan.scheme.model_dump()["upsampling"] == 4


def test_the_letter_stands_on_whole_pixels(short: Recording) -> None:
    assert short.truth is not None
    rows, columns = np.nonzero(short.truth.image > 0.5)
    assert (columns.min(), rows.min(), rows.max()) == (9, 5, 42)
    assert np.count_nonzero(short.truth.image > 0.5) == 898


def test_a_part_of_a_run_is_its_beginning_and_a_seed_is_its_noise(short: Recording) -> None:
    assert short.truth is not None
    middle_s = (np.arange(len(short), dtype=np.float64) + 0.5) * short.frame_time_s
    whole = accelerated(100 * 6 * 50e-6 / 0.06)(middle_s)
    np.testing.assert_allclose(short.truth.displacement_px, whole - whole[0], atol=1e-6)
    other = record(SHORT, seed=4)
    assert not np.array_equal(short.values, other.values)
    np.testing.assert_array_equal(short.values, record(SHORT, seed=3).values)


def test_as_published_is_the_phase_of_each_frame_by_itself(short: Recording, published: Outcome) -> None:
    """Equations 6, 8 and 9, written out; f = 2 / 128. The lamp's drift, of which there is none here but noise, is divided out."""
    values = short.values
    total = values[:, 4] + values[:, 5]
    error: list[Floats] = []
    assert short.truth is not None
    for axis, column in enumerate((0, 2)):
        coefficient = (2 * values[:, column] - total) + 1j * (2 * values[:, column + 1] - total)
        phase = np.unwrap(np.angle(coefficient * np.conj(coefficient[0])))
        error.append(-phase / (2 * np.pi * 2 / 128) - short.truth.displacement_px[:, axis])
    assert published.figures["mse_px2"] == pytest.approx(float(np.mean(np.square(error))), rel=1e-3)


def test_the_filter_takes_the_mean_of_five_coefficients(short: Recording, published: Outcome) -> None:
    plain, filtered = as_published(short, ghost=True), as_published(short, mean_filter=5, ghost=True)
    assert plain.figures["mse_px2"] == published.figures["mse_px2"]
    assert plain.figures["psnr_db"] < published.figures["psnr_db"]
    five = track(replace(Measurement.of(short), light_found=True), "per-frame", mean_filter=5)
    assert short.truth is not None
    error = five.displacement_px - short.truth.displacement_px
    assert filtered.figures["mse_px2"] == pytest.approx(float(np.mean(error**2)))
    assert filtered.figures["mse_px2"] < 0.6 * plain.figures["mse_px2"]


def test_as_published_asks_the_run_nothing_about_its_light() -> None:
    """A background that nobody measured moves the circle's centre: Kinopix takes it off, the paper does not."""
    settings = EXPERIMENT.model_copy(update={"background_ratio": 1.04, "peak_counts": 5000.0, "part": 0.3})
    recording = record(settings, seed=0)
    assert recording.background is not None
    assert recording.truth is not None
    assert recording.truth.background is not None
    assert recording.truth.image.sum() / recording.truth.background.sum() == pytest.approx(1.04, rel=1e-3)
    alone = replace(recording, background=None)
    found = track(alone, "smooth").displacement_px - recording.truth.displacement_px
    assert as_published(alone, ghost=True).figures["mse_px2"] > 3 * float(np.mean(found**2))
    assert as_published(recording, ghost=True).figures["mse_px2"] < 0.3


def test_the_background_is_counted_anew(short: Recording) -> None:
    settings = EXPERIMENT.model_copy(update={"background_ratio": 8.6, "part": 0.02})
    one, two = record(settings, seed=0), record(settings, seed=1)
    assert one.background is not None
    assert two.background is not None
    assert not np.array_equal(one.background, two.background)
    assert one.background.sum() < 0.2 * one.values.sum()
    with pytest.raises(InputError, match="counts no photons"):
        record(Simulated(background_ratio=2.0), seed=0)


def test_the_letters_are_an_i_and_a_t_beside_the_diagonal() -> None:
    letters = letters_beside()
    assert letters.sum() == 23 * 5 + 5 * 18 + 18 * 6
    assert not np.diag(letters).any()


def test_own_is_the_default_analysis(short: Recording, published: Outcome) -> None:
    outcome = own(short)
    assert outcome.figures["mse_px2"] < 0.8 * published.figures["mse_px2"]
    assert outcome.image.shape == (128, 128)
    assert "mse_px2" not in own(record(Simulated(scheme="hadamard", part=0.01), seed=0)).figures


def test_conventional_imaging_is_the_inverse_transform_of_all_pairs() -> None:
    recording = record(Simulated(scheme="hadamard", part=0.02, sigma=0.0), seed=0)
    outcome = as_published(recording)
    assert set(outcome.figures) == {"psnr_db", "ssim_global", "ssim_local"}
    difference = recording.values[:, 0] - recording.values[:, 1]
    assert outcome.image.sum() == pytest.approx(difference[0], rel=1e-9)  # the first pattern is all on


def test_a_spread_is_mean_and_deviation_of_one_seed() -> None:
    assert Spread.of([1.0, 2.0, 3.0]) == Spread(2.0, 1.0, 3)
    assert Spread.of([4.0]) == Spread(4.0, 0.0, 1)
    image = np.zeros((2, 2))
    outcomes = {("a, 1", seed): {"one": Outcome({"psnr_db": 10.0 + seed}, image)} for seed in (0, 2)}
    summary = Summary.of(tiny.STUDY, outcomes)
    assert summary.mean("a, 1", "one", "psnr_db") == 11.0
    assert np.isnan(summary.mean("a, 2", "one", "psnr_db"))
    assert summary.metrics == ["psnr_db"]


FiguresOf: TypeAlias = Callable[[Case, str], dict[str, float]]
"""Case and processing to figures of merit."""


def place(case: Case) -> float:
    """Give where a case stands along the axis."""
    return 0.0 if case.x is None else case.x


def claims_of(name: StudyName, figures: FiguresOf) -> list[bool]:
    """Whether the claims of a study hold for such figures."""
    study = STUDIES[name]
    outcomes = {
        (case.label, 0): {
            processing: Outcome(dict.fromkeys(METRICS, 0.0) | figures(case, processing), np.zeros((2, 2)))
            for processing in study.processings
        }
        for case in study.cases
    }
    return [claim.holds for claim in study.claims(Summary.of(study, outcomes))]


def test_the_claims_of_table_1_hold_for_the_paper_itself() -> None:
    study = STUDIES["table1"]

    def printed(case: Case, _processing: str) -> dict[str, float]:
        of_guo = {"ssim_local": 0.5 if "Guo" in case.label else 0.6}  # not printed
        return of_guo | {metric: value for (label, metric), value in study.paper.items() if label == case.label}

    assert all(claims_of("table1", printed))
    worse = claims_of("table1", lambda case, processing: printed(case, processing) | {"psnr_db": 19.0})
    assert not any(worse[4:10])


Trend: TypeAlias = Callable[[float, bool], dict[str, float]]
"""Place along the axis, and whether the paper's is the better processing or method, to figures of merit."""

TRENDS: list[tuple[StudyName, Trend, Trend]] = [
    ("frames", lambda x, _: {"psnr_db": -100.0 / x}, lambda x, _: {"psnr_db": x}),
    (
        "noise",
        lambda x, ours: {"mse_px2": x - ours, "psnr_db": ours - x},
        lambda x, _: {"mse_px2": -x, "psnr_db": x},
    ),
    ("upsampling", lambda _, __: {"mse_px2": 1.0}, lambda x, _: {"mse_px2": x}),
    ("speed", lambda _, __: {"psnr_db": 30.0}, lambda x, _: {"psnr_db": -x}),
    (
        "background",
        lambda x, ours: {"psnr_db": 30.0 - 5 * x + ours, "mse_px2": x / (1 + ours)},
        lambda x, _: {"psnr_db": x, "mse_px2": 1.0},
    ),
    ("dgi", lambda _, ours: {"psnr_db": 10.0 + ours}, lambda _, ours: {"psnr_db": 10.0 - ours}),
]
"""The paper's trend in each study, and its opposite."""


@pytest.mark.parametrize(("name", "trend", "opposite"), TRENDS)
def test_trends_are_told_from_their_opposite(name: StudyName, trend: Trend, opposite: Trend) -> None:
    def better(case: Case, processing: str) -> bool:
        return any(word in case.label + processing for word in ("the paper's", "filter", "TVAL3"))

    assert all(claims_of(name, lambda case, of: trend(place(case), better(case, of))))
    assert not any(claims_of(name, lambda case, of: opposite(place(case), better(case, of))))
