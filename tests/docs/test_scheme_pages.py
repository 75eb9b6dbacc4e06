"""Each scheme that comes with Kinopix has a page in ``docs/schemes``, whose settings are those that there are."""

import re
import tomllib
from pathlib import Path

import pytest

from instrument.config import installed_plugins
from instrument.plan import Plan

PAGES = Path(__file__).parents[2] / "docs" / "schemes"
OURS = [plugin.name for plugin in installed_plugins("scheme") if plugin.distribution == "kinopix"]


@pytest.mark.parametrize("scheme", OURS)
def test_the_settings_of_a_page_are_all_that_there_are_and_make_a_plan(scheme: str) -> None:
    page = (PAGES / f"{scheme}.md").read_text()
    (block,) = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    table = tomllib.loads(block)["scheme"]

    plan = Plan.model_validate({"frames": 10, "scheme": table})

    assert table.keys() == plan.scheme.model_dump().keys()
    defaults = Plan.model_validate({"frames": 10, "scheme": scheme}).scheme.model_dump(exclude={"shuffle_seed"})
    assert plan.scheme.model_dump(exclude={"shuffle_seed"}) == defaults


def test_the_index_lists_every_page_with_its_patterns_and_frame_rate() -> None:
    """20,000 patterns a second over the patterns of a frame."""
    index = (PAGES / "README.md").read_text()
    for scheme in OURS:
        patterns = Plan.model_validate({"frames": 10, "scheme": scheme}).patterns_per_frame
        assert re.search(
            rf"\| \[{scheme}\]\({scheme}\.md\) \| {patterns}: .* \| {round(20_000 / patterns):,} \|", index
        )
    assert {path.stem for path in PAGES.glob("*.md")} == {*OURS, "README"}
