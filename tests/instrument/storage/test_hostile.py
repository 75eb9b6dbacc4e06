"""Whatever is in a file, reading it gives a recording or an ``InputError`` that names the place inside the file."""

import os
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import h5py  # pyright: ignore[reportMissingTypeStubs]
import numpy as np
import pytest

from instrument.plan import Plan
from instrument.recording import Recording
from instrument.storage import RecordingWriter, open_recording, refuse_unchangeable, write_analysis
from protocols import CountBlock, InputError, Truth
from tests.support import plain_hdf5 as plain

h5: Any = h5py

PLAN = Plan(frames=8, image_size=8)
LONGEST_S: Final = 10.0
"""No answer takes so long; most take some milliseconds."""

Harm = Callable[[Any], None]


def write(path: Path) -> Path:
    with RecordingWriter(path, PLAN, picture_time_s=50e-6, with_truth=True) as writer:
        counts = np.arange(48)
        writer.append_raw(CountBlock(first_bin=0, counts=counts.astype(np.uint32)))
        writer.append(counts.astype(np.float64), counts * np.float64(50e-6))
        writer.finish(truth=Truth(displacement_px=np.ones((8, 2)), image=np.eye(8)))
    return path


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return write(tmp_path / "run.h5")


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    return write(tmp_path_factory.mktemp("sound") / "run.h5").read_bytes()


def put(name: str, value: object) -> Harm:
    """Put something else in the place of a dataset."""

    def harm(file: Any) -> None:
        del file[name]
        file[name] = value

    return harm


def without(name: str) -> Harm:
    def harm(file: Any) -> None:
        del file[name]

    return harm


def hollow(name: str, shape: tuple[int, ...], **options: object) -> Harm:
    """Declare a shape, and store nothing."""

    def harm(file: Any) -> None:
        del file[name]
        file.create_dataset(name, shape=shape, dtype=np.float64, **options)

    return harm


def virtual(file: Any) -> None:
    layout = h5.VirtualLayout(shape=(8, 6), dtype=np.float64)
    layout[:] = h5.VirtualSource("other.h5", "entry/data/values", shape=(8, 6))
    del file["entry/data/values"]
    file.create_virtual_dataset("entry/data/values", layout)


def group_for_values(file: Any) -> None:
    del file[VALUES]
    file.create_group(VALUES)


def in_another_file(file: Any) -> None:
    Path(file.filename).with_name("raw").write_bytes(bytes(384))
    del file["entry/data/values"]
    file.create_dataset("entry/data/values", shape=(8, 6), dtype=np.float64, external=[("raw", 0, 384)])


def references(name: str, kind: Any = h5.ref_dtype) -> Harm:
    """Put object references in the place of a dataset, there or not."""

    def harm(file: Any) -> None:
        file.pop(name, None)
        data = file.create_dataset(name, shape=(3,), dtype=kind)
        if kind is h5.ref_dtype:
            data[0] = file["entry/plan"].ref

    return harm


def attribute(name: str, key: str, value: object) -> Harm:
    def harm(file: Any) -> None:
        file[name].attrs[key] = value

    return harm


PICTURE_TIME, VALUES = "entry/instrument/modulator/picture_time_s", "entry/data/values"

HARMS: dict[str, tuple[Harm, str]] = {
    "text for values": (put(VALUES, "x"), "/entry/data/values holds no numbers"),
    "complex values": (put(VALUES, np.ones((8, 6), complex)), "/entry/data/values holds no numbers, but complex128"),
    "references for values": (references(VALUES), "/entry/data/values holds no numbers"),
    "a group for values": (group_for_values, "/entry/data/values is no dataset"),
    "values of three axes": (put(VALUES, np.ones((8, 6, 1))), r"values of shape \(8, 6, 1\)"),
    "no values": (without(VALUES), "/entry/data/values is missing"),
    "no data": (without("entry/data"), "/entry/data/values is missing"),
    "a number for a group": (put("entry/data", 3.0), "/entry/data is no group"),
    "no plan": (without("entry/plan"), "/entry/plan is missing"),
    "a number for a plan": (put("entry/plan", 3.0), "/entry/plan is no text, but float64"),
    "a list for a plan": (put("entry/plan", "[1, 2]"), "does not know .* at /entry/plan"),
    "null for a plan": (put("entry/plan", "null"), "does not know .* at /entry/plan"),
    "a deep plan": (put("entry/plan", "[" * 100_000), "does not know .* at /entry/plan"),
    "a plan of wrong types": (put("entry/plan", '{"frames": [], "scheme": 3}'), "does not know .* at /entry/plan"),
    "a mask of text": (put("entry/timing/frame_valid", "x"), "/entry/timing/frame_valid holds no numbers"),
    "a mask of two axes": (put("entry/timing/frame_valid", np.ones((8, 1))), r"a mask of \(8, 1\) frames"),
    "short edge times": (put("entry/data/edge_time_s", np.ones((7, 6))), r"edge times of shape \(7, 6\)"),
    "a flat truth": (put("entry/truth/displacement_px", np.ones(16)), "at /entry/truth, not"),
    "a small truth": (put("entry/truth/image", np.ones((4, 4))), "at /entry/truth, not"),
    "a small background": (put("entry/truth/background", np.ones((4, 8))), "at /entry/truth, not"),
    "a broken background": (put("entry/truth/background", np.full((8, 8), np.nan)), "not finite at /entry/truth"),
    "a report of numbers": (put("entry/timing/report", 3), "/entry/timing/report is no text"),
    "picture time 0": (put(PICTURE_TIME, 0.0), f"0 at /{PICTURE_TIME}, not more than 0 s"),
    "picture time -1": (put(PICTURE_TIME, -1.0), f"-1 at /{PICTURE_TIME}, not more than 0 s"),
    "picture time NaN": (put(PICTURE_TIME, np.nan), f"nan at /{PICTURE_TIME}"),
    "picture time inf": (put(PICTURE_TIME, np.inf), f"inf at /{PICTURE_TIME}"),
    "picture times": (put(PICTURE_TIME, np.ones(2)), f"/{PICTURE_TIME} is not one number"),
    "no number at all": (put(PICTURE_TIME, h5.Empty("f8")), f"/{PICTURE_TIME} is not one number"),
    "negative dead time": (put("entry/instrument/counter/dead_time_s", -1e-9), "dead_time_s, not 0 s or more"),
    "dark rate NaN": (put("entry/instrument/counter/dark_rate_hz", np.nan), "dark_rate_hz, not 0 Hz or more"),
    "a dangling link": (put(VALUES, h5.SoftLink("/nowhere")), "/entry/data/values is a link to somewhere else"),
    "a link to itself": (put(VALUES, h5.SoftLink("/" + VALUES)), "/entry/data/values is a link to somewhere else"),
    "a good soft link": (put("entry/title", h5.SoftLink("/entry/plan")), "/entry/title is a soft link"),
    "a link for a group": (put("entry/instrument", h5.SoftLink("/entry/data")), "/entry/instrument is a link"),
    "a link out": (put(VALUES, h5.ExternalLink("other.h5", VALUES)), "/entry/data/values is a link to somewhere else"),
    "a link to a pipe": (
        put(VALUES, h5.ExternalLink("pipe", VALUES)),
        "/entry/data/values is a link to somewhere else",
    ),
    "virtual values": (virtual, "/entry/data/values holds nothing itself"),
    "values in another file": (in_another_file, "/entry/data/values holds nothing itself"),
    "a terabyte of nothing": (
        hollow(VALUES, (20_000_000_000, 6), chunks=(1024, 6)),
        "/entry/data/values is float64 of shape .*, of which the file holds 0",
    ),
    "a gigabyte of nothing, packed": (
        hollow(VALUES, (20_000_000, 6), chunks=(1024, 6), compression="gzip"),
        "of which the file holds 0",
    ),
    "raw nothing": (hollow("entry/truth/image", (8, 1_000_000_000)), "/entry/truth/image is float64 .* file holds 0"),
    "an odd version": (attribute("entry/definition", "version", [1, 2]), "a recording of layout"),
    "no version": (lambda f: f["entry/definition"].attrs.__delitem__("version"), "a recording of layout None"),
    "values of another run": (put(VALUES, np.ones((8, 6))), "values of frames 0 to 7 that were changed"),
}


def harmed(path: Path, harm: Harm) -> None:
    write(path.with_name("other.h5"))
    if sys.platform != "win32":
        os.mkfifo(path.with_name("pipe"))  # whoever opens it waits for ever
    with plain.opened(path, "r+") as file:
        harm(file)


@pytest.mark.parametrize("name", HARMS)
def test_what_is_wrong_is_told_with_its_place_in_the_file(path: Path, name: str) -> None:
    harm, told = HARMS[name]
    harmed(path, harm)
    before = path.read_bytes()
    with pytest.raises(InputError, match=told):
        analyse(path)
    assert path.read_bytes() == before


def analyse(path: Path) -> Recording:
    """Read a recording and store an analysis in it."""
    recording = open_recording(path)
    write_analysis(path, displacement_px=np.ones((len(recording), 2)), image=None)
    return recording


FOREIGN: dict[str, tuple[Callable[[str], Harm], str]] = {
    "soft link": (lambda name: add(name, h5.SoftLink("/entry/plan")), " is a soft link"),
    "dangling link": (lambda name: add(name, h5.SoftLink("/nowhere")), " is a soft link"),
    "link out": (lambda name: add(name, h5.ExternalLink("other.h5", "entry")), " is a link into another file"),
    "link to a pipe": (lambda name: add(name, h5.ExternalLink("pipe", "entry")), " is a link into another file"),
    "references": (references, " holds references"),
    "references in rows": (lambda name: references(name, np.dtype([("a", h5.ref_dtype)])), " holds references"),
    "an attribute": (lambda name: both(add(name, 3), pointing(name)), "/@to holds references"),
}


def add(name: str, value: object) -> Harm:
    def harm(file: Any) -> None:
        file[name] = value

    return harm


def both(first: Harm, second: Harm) -> Harm:
    def harm(file: Any) -> None:
        first(file)
        second(file)

    return harm


def pointing(name: str) -> Harm:
    """Let an attribute point to something."""

    def harm(file: Any) -> None:
        file[name].attrs["to"] = file["entry/plan"].ref

    return harm


@pytest.mark.parametrize("name", FOREIGN)
@pytest.mark.parametrize("place", ["extra", "entry/extra", "entry/instrument/stage/extra"])
def test_what_points_elsewhere_is_never_copied(path: Path, name: str, place: str) -> None:
    """It is not read either: the recording beside it is."""
    make, told = FOREIGN[name]
    harmed(path, make(place))
    before = path.read_bytes()
    assert len(open_recording(path)) == 8
    with pytest.raises(InputError, match=f"/{place}{told}"):
        refuse_unchangeable(path)
    with pytest.raises(InputError, match=f"/{place}{told}"):
        write_analysis(path, displacement_px=np.ones((8, 2)), image=None)
    assert path.read_bytes() == before


def test_a_pipe_is_no_recording(tmp_path: Path) -> None:
    if sys.platform == "win32":
        pytest.skip("no pipes in folders")
    os.mkfifo(tmp_path / "run.h5")
    with pytest.raises(InputError, match=r"no ordinary file: .*run\.h5"):
        analyse(tmp_path / "run.h5")


def test_a_recording_that_was_packed_is_read(path: Path) -> None:
    """As h5repack makes it."""
    with plain.opened(path, "r+") as file:
        values = file[VALUES][:]
        del file[VALUES]
        file.create_dataset(VALUES, data=values, chunks=(8, 6), compression="gzip", shuffle=True)
    np.testing.assert_array_equal(open_recording(path).values.ravel(), np.arange(48))


def answers(path: Path) -> Recording | InputError:
    """Read and analyse; give what comes of it, in time."""
    begin_s = time.monotonic()
    try:
        return analyse(path)
    except InputError as error:
        return error
    finally:
        assert time.monotonic() - begin_s < LONGEST_S


TEXTS = ("", "null", "[]", "{}", "1e999", '{"a": 1}', "\x00", "ä" * 70_000, '"' * 9, "[" * 9999, '{"frames": 1e400}')


def some_value(dice: np.random.Generator) -> object:
    """Something to put anywhere."""
    shape = [(), (0,), (1,), (8,), (8, 6), (8, 6, 1), (6, 8), (0, 6), (8, 2)][dice.integers(9)]
    values: list[object] = [
        dice.choice([0.0, -1.0, np.nan, np.inf, 1e308, 5e-324]),
        np.full(shape, dice.choice([0.0, -1.0, np.nan, np.inf, 1e308])),
        np.ones(shape, dice.choice(["i1", "u8", "f2", ">f8", "c8", "S3", "?"])),
        np.zeros(shape, np.dtype([("a", "f8"), ("b", "i4")])),
        np.zeros(shape, h5.opaque_dtype(np.dtype("M8[s]"))),
        h5.Empty(dice.choice(["f8", "S5"])),
        str(dice.choice(TEXTS)).replace("\x00", " "),
        np.array(dice.bytes(9)),
        h5.SoftLink(str(dice.choice(["/", "/entry", "nowhere", "/entry/data/values"]))),
        h5.ExternalLink("other.h5", "/entry"),
        h5.ExternalLink("pipe", "/"),
    ]
    return values[dice.integers(len(values))]


def mutate(file: Any, dice: np.random.Generator) -> None:
    """Change one thing of a file."""
    names: list[str] = []
    file.visit(names.append)
    name = names[dice.integers(len(names))]
    match int(dice.integers(7)):
        case 0:
            del file[name]
        case 1:
            item = file[name]
            keys = [*item.attrs, "version", "complete"]
            item.attrs.pop(key := keys[dice.integers(len(keys))], None)
            value = some_value(dice)
            if not isinstance(value, h5.SoftLink | h5.ExternalLink) and not (
                isinstance(value, str) and len(value) > 9999
            ):
                item.attrs[key] = value
        case 2:
            file.move(name, f"{name}/{name}" if dice.integers(2) else "elsewhere")
        case 3:
            del file[name]
            shape = tuple(dice.choice([0, 1, 6, 8, 10**6, 10**12], dice.integers(1, 4)).tolist())
            if np.prod(shape, dtype=float) < 1e18:
                file.create_dataset(name, shape=shape, dtype="f8", chunks=tuple(min(8, max(1, n)) for n in shape))
        case 4:
            other = names[dice.integers(len(names))]
            if not other.startswith(name):
                del file[name]
                file[name] = file[other]  # a second name: also a group below itself
        case 5:
            references(name, [h5.ref_dtype, h5.regionref_dtype][dice.integers(2)])(file)
        case _:
            del file[name]
            file[name] = some_value(dice)


BATCHES = [pytest.param(k, marks=[pytest.mark.thorough] if k > 2 else []) for k in range(6)]


@pytest.mark.parametrize("batch", BATCHES)
def test_a_file_of_a_random_structure_is_read_or_refused(tmp_path: Path, sound: bytes, batch: int) -> None:
    """Three hundred files, with one to three things changed in each."""
    write(tmp_path / "other.h5")
    if sys.platform != "win32":
        os.mkfifo(tmp_path / "pipe")
    refused = 0
    for seed in range(50 * batch, 50 * batch + 50):
        dice = np.random.default_rng(seed)
        path = tmp_path / f"{seed}.h5"
        path.write_bytes(sound)
        with plain.opened(path, "r+") as file:
            for _ in range(dice.integers(1, 4)):
                try:
                    mutate(file, dice)
                except (ValueError, KeyError, OSError, RuntimeError, TypeError):
                    continue  # h5py does not write that
        refused += isinstance(answers(path), InputError)
    assert 10 < refused < 50


@pytest.mark.parametrize("batch", BATCHES)
def test_a_file_of_flipped_bytes_is_read_or_refused(tmp_path: Path, sound: bytes, batch: int) -> None:
    """Three hundred files, with one to eight bytes changed in each. No value is changed without a word."""
    expected = np.arange(48.0)
    filled = np.flatnonzero(np.frombuffer(sound, np.uint8))  # most of a small file is empty room
    refused = 0
    for seed in range(50 * batch, 50 * batch + 50):
        dice = np.random.default_rng(seed)
        raw = np.frombuffer(sound, np.uint8).copy()
        where = dice.choice(filled if dice.integers(4) else len(raw), dice.integers(1, 9))
        raw[where] ^= dice.integers(1, 256, len(where)).astype(np.uint8)
        path = tmp_path / f"{seed}.h5"
        path.write_bytes(raw.tobytes())
        answer = answers(path)
        if isinstance(answer, InputError):
            refused += 1
        else:
            np.testing.assert_array_equal(answer.values.ravel(), expected)
    assert 10 < refused < 50
