"""A configuration file is read, or refused with every mistake at once."""

from pathlib import Path
from typing import Annotated, Literal

import pytest
from pydantic import Field, PositiveInt

from instrument.config import ConfigError, read_document, validate_table
from instrument.plan import Plan
from instrument.schemes import FourierHadamardSettings
from protocols import Frozen, InputError


def problems_of(path: Path, text: str, model: type[Frozen] = Plan) -> list[str]:
    """Each mistake in ``text`` as it is shown, without the folder."""
    path.write_text(text)
    try:
        document = read_document(path)
        value, problems = validate_table(model, document.values, document)
        assert value is None
        found = ConfigError(path, problems)
    except ConfigError as error:
        found = error
    return [str(problem).removeprefix(f"{path.parent}/") for problem in found.problems]


def plan_problems(path: Path, text: str) -> list[str]:
    """Likewise, of a plan."""
    path.write_text(text)
    with pytest.raises(ConfigError) as caught:
        Plan.from_toml(path)
    return [str(problem).removeprefix(f"{path.parent}/") for problem in caught.value.problems]


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "plan.toml"


def test_a_good_plan_is_read(path: Path) -> None:
    path.write_text("frames = 1666\n[motion]\nvelocity_mm_s = 25\n")
    plan = Plan.from_toml(path)
    assert plan.frames == 1666
    assert plan.motion is not None
    assert plan.motion.velocity_mm_s == 25.0


def test_all_mistakes_are_told_at_once_with_line_and_suggestion(path: Path) -> None:
    found = plan_problems(
        path,
        'frames = "many"\nimagesize = 128\nscheme.hadamard_order = "TVs"\n\n[motion]\n'
        "velocity_um_s = 25000.0\nacceleration_mm_s2 = -3\n",
    )
    assert [problem.split(";")[0] for problem in found] == [
        'plan.toml:1: frames: saw "many"',
        "plan.toml:2: imagesize: saw an unknown key",
        'plan.toml:3: scheme.hadamard_order: saw "TVs"',
        "plan.toml:5: motion.velocity_mm_s: saw nothing",
        "plan.toml:6: motion.velocity_um_s: saw an unknown key",
        "plan.toml:7: motion.acceleration_mm_s2: saw -3",
    ]
    assert [problem.split("expected ")[1] for problem in (found[0], found[5])] == ["a whole number", "greater than 0"]
    assert "(did you mean image_size?)" in found[1]
    assert "expected 'tv', 'tv-isotropic', " in found[2]
    assert "'natural' or 'random' (did you mean 'tv'?)" in found[2]
    assert "(is velocity_um_s meant to be velocity_mm_s?)" in found[3]
    assert "(did you mean velocity_mm_s, in mm/s? Convert the value from um/s)" in found[4]


def test_the_error_is_one_readable_text_and_an_input_error(path: Path) -> None:
    path.write_text("frames = 0\nrate = 5\n")
    with pytest.raises(InputError) as caught:
        Plan.from_toml(path)
    assert caught.value.exit_code == 2
    lines = str(caught.value).splitlines()
    assert lines[0] == f"2 mistakes in {path}:"
    assert lines[1] == f"  {path}:1: frames: saw 0; expected greater than 0"
    assert lines[2].startswith(f"  {path}:2: rate: saw an unknown key; expected one of scheme, frames, ")


def test_numbers_are_not_guessed_from_text_or_fractions(path: Path) -> None:
    """Pydantic alone would take "25" as 25 and 2.0 as 2."""
    assert plan_problems(
        path, 'frames = 10\npattern_rate_hz = "20000"\nsuperpixel = 2.0\nscheme.upsampling = true\n'
    ) == [
        'plan.toml:2: pattern_rate_hz: saw "20000"; expected a number',
        "plan.toml:3: superpixel: saw 2.0; expected a whole number",
        "plan.toml:4: scheme.upsampling: saw true; expected a whole number",
    ]


def test_a_rule_of_the_model_is_told_at_the_key_that_it_names(path: Path) -> None:
    assert problems_of(path, "frames = 10\nimage_size = 100\n") == [
        (
            "plan.toml:2: image_size: saw 100; expected another value "
            "(image_size is 100: Hadamard patterns need a power of two, 8 or more)"
        )
    ]
    assert problems_of(path, "frames = 10\n[motion]\nvelocity_mm_s = 0\n") == [
        (
            "plan.toml:3: motion.velocity_mm_s: saw 0; expected another value "
            "(is 0: leave out the whole [motion] table for an object at rest)"
        )
    ]


def test_an_empty_file_lacks_what_is_required(path: Path) -> None:
    assert problems_of(path, "") == ["plan.toml: frames: saw nothing; expected a value for frames"]


def test_a_table_where_a_value_belongs_and_the_other_way_round(path: Path) -> None:
    assert problems_of(path, "frames = { n = 3 }\nmotion = 3\n") == [
        "plan.toml:1: frames: saw this table; expected a whole number",
        "plan.toml:2: motion: saw 3; expected a table",
    ]


class Pixel(Frozen):
    kind: Literal["pixel"]
    sigma: float


class Poisson(Frozen):
    kind: Literal["poisson"]
    peak_counts: float


class Scene(Frozen):
    noise: Annotated[Pixel | Poisson, Field(discriminator="kind")]
    size: int | list[PositiveInt] = 1


def test_members_of_a_union_do_not_show_in_the_key_path(path: Path) -> None:
    assert problems_of(path, '[noise]\nkind = "pixel"\nsigmas = 1\nsigma = "x"\n', Scene) == [
        "plan.toml:3: noise.sigmas: saw an unknown key; expected one of kind, sigma, peak_counts",
        'plan.toml:4: noise.sigma: saw "x"; expected a number',
    ]
    assert problems_of(path, '[noise]\nkind = "poison"\nsigma = 1\n', Scene) == [
        "plan.toml:2: noise.kind: saw \"poison\"; expected one of 'pixel', 'poisson' (did you mean 'poisson'?)"
    ]
    assert problems_of(path, "noise = { knd = 1 }\n", Scene) == [
        "plan.toml:1: noise.kind: saw nothing; expected a value for kind (is knd meant to be kind?)"
    ]


def test_one_problem_for_all_members_of_a_union(path: Path) -> None:
    text = 'size = "x"\n[noise]\nkind = "pixel"\nsigma = 1\n'
    assert problems_of(path, text, Scene) == ['plan.toml:1: size: saw "x"; expected a whole number, or a list']
    text = 'size = [1, 0]\n[noise]\nkind = "pixel"\nsigma = 1\n'
    assert "plan.toml:1: size.1: saw 0; expected greater than 0" in problems_of(path, text, Scene)


def test_a_syntax_error_names_its_line_and_shows_it(path: Path) -> None:
    assert problems_of(path, "frames = 10\nimage_size 128\n") == [
        "plan.toml:2: saw 'image_size 128'; expected valid TOML (Expected '=' after a key in a key/value pair)"
    ]
    assert problems_of(path, "frames = 10\nframes = 11\n")[0].startswith("plan.toml:2: saw 'frames = 11'")
    assert problems_of(path, 'frames = 10\nscheme = """\n')[0].startswith('plan.toml:2: saw \'scheme = """\'')


def test_a_missing_file_tells_what_the_folder_holds(tmp_path: Path) -> None:
    (tmp_path / "bench.toml").touch()
    with pytest.raises(ConfigError, match=r"plan\.toml: saw no such file; .*holds bench\.toml"):
        Plan.from_toml(tmp_path / "plan.toml")


def test_a_folder_is_no_file(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="saw a folder; expected a TOML file"):
        Plan.from_toml(tmp_path)


def test_other_encodings_are_told(path: Path) -> None:
    path.write_bytes(b"frames = 10\n# 20 \xb5m\n")
    with pytest.raises(ConfigError, match=r"plan\.toml:2: saw byte 0xb5, which is not UTF-8"):
        Plan.from_toml(path)
    path.write_text("frames = 10\n", encoding="utf-16")
    with pytest.raises(ConfigError, match="saw text in UTF-16; expected UTF-8"):
        Plan.from_toml(path)


def test_a_byte_order_mark_does_no_harm(path: Path) -> None:
    path.write_text("frames = 10\n", encoding="utf-8-sig")
    assert Plan.from_toml(path).frames == 10


def test_a_long_value_is_shown_short(path: Path) -> None:
    (problem,) = problems_of(path, f"frames = [{', '.join(['1'] * 100)}]\n")
    assert problem == f"plan.toml:1: frames: saw [{'1, ' * 18}1,...; expected a whole number"


def test_brackets_without_end_are_no_crash(path: Path) -> None:
    path.write_text("frames = " + "[" * 5000 + "]" * 5000)
    with pytest.raises(ConfigError, match="nested"):
        read_document(path)


def test_a_scheme_is_named_or_has_a_table_of_its_own(path: Path) -> None:
    path.write_text('frames = 10\nscheme = "fourier-hadamard"\n')
    assert Plan.from_toml(path).scheme == FourierHadamardSettings()
    path.write_text('frames = 10\n[scheme]\nname = "fourier-hadamard"\nfourier_cycles = 1\nshuffle_seed = 3\n')
    assert Plan.from_toml(path).scheme == FourierHadamardSettings(fourier_cycles=1, shuffle_seed=3)
    path.write_text("frames = 10\n[scheme]\nupsampling = 2\n")
    assert Plan.from_toml(path).scheme == FourierHadamardSettings(upsampling=2)


def test_mistakes_of_a_scheme_are_told_with_those_of_the_plan(path: Path) -> None:
    found = plan_problems(path, 'frame = 10\nscheme = "fourier-hadamart"\n')
    assert found[0].startswith(
        "plan.toml: frames: saw nothing; expected a value for frames (is frame meant to be frames?)"
    )
    assert found[2].startswith(
        "plan.toml:2: scheme: saw 'fourier-hadamart', a scheme plug-in that no installed distribution"
    )
    assert "did you mean 'fourier-hadamard'?" in found[2]
    found = plan_problems(path, "frames = 10\n[scheme]\nfourier_cycle = 2\n")
    assert len(found) == 1
    assert found[0].startswith("plan.toml:3: scheme.fourier_cycle: saw an unknown key")
    assert "(did you mean fourier_cycles?)" in found[0]
    found = plan_problems(path, "frames = 10\n[scheme]\nupsampling = 3\n")
    assert found == [
        (
            "plan.toml:3: scheme.upsampling: saw 3; expected another value "
            "(scheme.upsampling is 3: it must divide superpixel = 2, the mirrors a pixel side)"
        )
    ]
    assert plan_problems(path, "frames = 10\nscheme = 3\n") == [
        'plan.toml:2: scheme: saw 3; expected the name of a scheme ("fourier-hadamard")'
    ]


def test_a_key_that_once_stood_beside_the_scheme_is_told_where_it_belongs(path: Path) -> None:
    found = plan_problems(path, "frames = 10\nfourier_cycles = 1\n")
    assert len(found) == 1
    assert found[0].startswith("plan.toml:2: fourier_cycles: saw an unknown key")
    assert found[0].endswith("(move it into a [scheme] table)")


def test_a_plan_in_a_recording_of_version_0_1_is_read() -> None:
    plan = Plan.from_json('{"scheme": "fourier-hadamard", "frames": 5, "upsampling": 2, "hadamard_order": "natural"}')
    assert plan == Plan(frames=5, scheme=FourierHadamardSettings(upsampling=2, hadamard_order="natural"))
    assert Plan.from_json(plan.model_dump_json()) == plan
