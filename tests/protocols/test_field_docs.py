"""What stands below a field reaches ``help()``, and nothing else."""

import pydoc
from dataclasses import dataclass

import pytest

import kinopix
from protocols import DeviceIdentity, Frozen, MotionProfile
from protocols.field_docs import field_docstrings, own_docstring, with_fields


class Lens(Frozen):
    """A lens."""

    focal_length_mm: float
    """Distance of the focus,
    from the middle."""

    name: str = "no name"
    """What it is called."""

    bare: int = 0


class Zoom(Lens):
    """A lens whose focal length can be changed."""

    longest_mm: float = 100.0
    """Longest focal length."""


@with_fields
@dataclass(frozen=True)
class Image:
    """An image."""

    width_px: int
    """How wide it is."""

    gain: float = 1.0
    """Factor on its grey."""


def test_a_model_lists_each_field_with_default_and_meaning() -> None:
    assert Lens.__doc__ == (
        "A lens.\n\nFields:\n    focal_length_mm: Distance of the focus, from the middle.\n"
        "    name = 'no name': What it is called."
    )


def test_a_model_lists_the_fields_that_it_extends_first() -> None:
    lines = (Zoom.__doc__ or "").splitlines()
    assert lines[0] == "A lens whose focal length can be changed."
    assert [line.split()[0].rstrip(":") for line in lines[3:]] == ["focal_length_mm", "name", "longest_mm"]


def test_a_dataclass_does_likewise() -> None:
    assert Image.__doc__ == "An image.\n\nFields:\n    width_px: How wide it is.\n    gain = 1.0: Factor on its grey."


def test_the_text_as_it_was_written_is_still_there() -> None:
    assert own_docstring(Lens) == "A lens."
    assert own_docstring(Image) == "An image."
    assert own_docstring(int) == int.__doc__


def test_a_class_that_was_made_in_memory_keeps_its_text_alone() -> None:
    names: dict[str, type[Frozen]] = {}
    exec('from protocols import Frozen\nclass Thing(Frozen):\n    """A thing."""\n    size: int = 1\n', names)  # noqa: S102
    assert names["Thing"].__doc__ == "A thing."
    assert field_docstrings(names["Thing"]) == {}


@pytest.mark.parametrize(
    "name", ["Analysis", "Figures", "Measurement", "MotionPlan", "Plan", "Reconstruction", "Recording"]
)
def test_help_shows_the_fields_of_what_a_lab_script_handles(name: str) -> None:
    of = getattr(kinopix, name)
    said = pydoc.plain(pydoc.render_doc(of))
    fields = getattr(of, "model_fields", None) or of.__dataclass_fields__
    assert [field for field in fields if f"    {field}" not in said.split("Fields:")[1]] == []


def test_values_of_the_protocols_too() -> None:
    assert "vendor: Maker of the device." in (DeviceIdentity.__doc__ or "")
    assert "velocity_mm_s" in (MotionProfile.__doc__ or "")
