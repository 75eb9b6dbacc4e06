"""The how-to of each device asks what ``kinopix probe --commission`` asks, word for word."""

import re
from itertools import chain
from pathlib import Path

import pytest

from instrument.config import find_plugin, list_plugins

PAGES = Path(__file__).parents[2] / "docs" / "how-to"
ASKED = {
    "dlp7000": [("modulator", "dlp7000")],
    "dlpc900": [("modulator", "dlpc900")],
    "h10682": [("counter", "ni"), ("counter", "usb-ctr")],
    "ni-analog": [("counter", "ni-analog")],
    "serial-counter": [("counter", "serial-counter")],
    "ka400z": [("stage", "ka400z")],
    "zaber": [("stage", "zaber")],
    "grbl": [("stage", "grbl")],
}


@pytest.mark.parametrize("page", ASKED)
def test_the_page_ends_with_the_questions_of_its_drivers(page: str) -> None:
    text = (PAGES / f"{page}.md").read_text(encoding="utf-8").split("\n## Open bench questions\n")[1]
    on_page = [
        " ".join(item.split()) for item in re.findall(r"^\d+\. (.*?)(?=^\d+\. |^#|\Z)", text, re.MULTILINE | re.DOTALL)
    ]
    plugins = [find_plugin(kind, name).load_driver() for kind, name in ASKED[page]]
    asked = {question.text: question for question in chain.from_iterable(plugin.questions for plugin in plugins)}
    assert {item.rpartition(" *(")[0] for item in on_page} == set(asked)
    for item in on_page:
        question, how = asked[item.rpartition(" *(")[0]], item.rpartition(" *(")[2]
        assert ("measured: " in how, "asked" in how, "by hand" in how) == (
            question.measured is not None,
            question.ask is not None,
            bool(question.by_hand),
        )
        assert question.measured is None or f"measured: {question.measured}" in how


def test_every_real_driver_has_questions() -> None:
    asked = set(chain.from_iterable(ASKED.values()))
    drivers = {
        (line.plugin.kind, line.plugin.name)
        for line in list_plugins()
        if line.plugin.kind in {"modulator", "counter", "stage"} and line.plugin.distribution == "kinopix"
    }
    assert {(kind, name) for kind, name in drivers if name != "simulated"} == asked
