"""The page in Chromium: what a person sees and does. Without the browser these tests skip, and say how to get one."""

from collections.abc import Generator
from pathlib import Path
from threading import Thread
from typing import Any

import numpy as np
import pytest
from PIL import Image

from instrument.live import LiveAnalysis
from instrument.plan import Plan
from instrument.session import ImageEvent, Instrument, Run, RunAborted
from instrument.storage import write_analysis
from instrument.web import Board, Desk, PageServer, RunPage, Shelf
from tests.support.benches import SMALL, bench_toml
from tests.support.browser import CHROMIUM, HOW_TO_GET_ONE, browser
from tests.support.held import HeldCounter

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason=HOW_TO_GET_ONE)

PLAN = SMALL.model_copy(update={"frames": 800})


@pytest.fixture(scope="module")
def chromium() -> Generator[Any]:
    with browser() as found:
        yield found


@pytest.fixture
def tab(chromium: Any) -> Generator[Any]:
    """A page of a desktop; anything that its scripts complain of fails the test."""
    context = chromium.new_context(viewport={"width": 1280, "height": 800})
    complaints: list[str] = []
    page = context.new_page()

    def hear(said: Any) -> None:
        if said.type in {"error", "warning"}:
            complaints.append(said.text)

    def fail(error: Any) -> None:
        complaints.append(str(error))

    page.on("pageerror", fail)
    page.on("console", hear)
    yield page
    context.close()
    assert complaints == []


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An analysed recording with a picture."""
    folder = tmp_path_factory.mktemp("past")
    with Instrument.from_toml(bench_toml(folder, 'object = "letter-B"')) as bench:
        bench.run(SMALL, folder / "before.h5")
    places = np.stack([np.arange(40.0), -np.arange(40.0)], axis=1)
    sigma = np.full((40, 2), 0.25)
    write_analysis(folder / "before.h5", displacement_px=places, sigma_px=sigma, image=None, table={"sigma_px": 0.25})
    Image.new("L", (64, 36), 128).save(folder / "before-summary.png")
    return folder


class Midst:
    """A run that is held after its second block of 1,000 patterns, with a page on it."""

    def __init__(self, instrument: Instrument, page: RunPage, server: PageServer, held: HeldCounter) -> None:
        self.instrument, self.page, self.server, self.held = instrument, page, server, held

    def begin(self, plan: Plan, out: Path) -> tuple[Run, Thread]:
        board = self.page.begins(self.instrument, plan)
        run = self.instrument.start(plan, out, listeners=[LiveAnalysis(plan), board])
        attending = Thread(target=self.page.attend, args=(run,))
        attending.start()
        assert self.held.there.wait(20)
        return run, attending


@pytest.fixture
def midst(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Generator[Midst]:
    board, desk = Board("the bench", control=True), Desk()
    shelf = Shelf(folder, lambda: board.over)
    bench = bench_toml(folder, 'object = "letter-B"\nnoise = { kind = "poisson", seed = 1 }')
    with PageServer(board, desk, shelf, port=0) as server, Instrument.from_toml(bench) as instrument:
        held = HeldCounter(instrument, monkeypatch, at=2)
        yield Midst(instrument, RunPage(board, desk), server, held)
        held.go.set()


def wait_for_text(tab: Any, selector: str, text: str) -> None:
    tab.locator(selector, has_text=text).wait_for(timeout=15_000)


def grey(tab: Any, canvas: str) -> tuple[int, int]:
    """The darkest and the brightest red of a canvas."""
    found = tab.evaluate(
        """id => {
          const c = document.getElementById(id), d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;
          const red = d.filter((_, k) => k % 4 === 0);
          return [red.reduce((a, b) => Math.min(a, b)), red.reduce((a, b) => Math.max(a, b))];
        }""",
        canvas,
    )
    return found[0], found[1]


def test_a_run_is_watched_reloaded_in_its_midst_and_stopped(midst: Midst, tab: Any, tmp_path: Path) -> None:
    tab.goto(midst.server.address)
    wait_for_text(tab, "#phase", "no run yet")
    run, attending = midst.begin(PLAN, tmp_path / "run.h5")
    for _ in range(2):
        wait_for_text(tab, "#patterns", "2000 of 4800 patterns counted")
        wait_for_text(tab, "#where", "frame 333")
        wait_for_text(tab, "#state", "running")
        wait_for_text(tab, "#devices", "simulated DLP7000")
        wait_for_text(tab, "#checks", "picture time: 50 us")
        wait_for_text(tab, "#light", "linear up to5.00 M/s")
        tab.locator("#noimage").wait_for(state="hidden", timeout=15_000)
        assert grey(tab, "image") == (0, 255)
        assert grey(tab, "field")[1] == 255
        assert tab.evaluate("kinopix.points") == 333
        assert tab.locator("#path").get_attribute("aria-label").startswith("Displacement after 333 frames: x ")
        tab.reload()
    wait_for_text(tab, "#state", "running")
    assert [tab.locator(f"[data-wish={wish}]").is_enabled() for wish in ("check", "start", "stop", "home")] == [
        False,
        False,
        True,
        False,
    ]
    tab.get_by_role("button", name="Stop").focus()
    tab.keyboard.press("Enter")
    wait_for_text(tab, "#notice", "stopped from the page")
    midst.held.go.set()
    attending.join(20)
    with pytest.raises(RunAborted, match="stopped from the page"):
        run.wait()
    wait_for_text(tab, "#ended", "patterns are kept in")
    assert tab.locator("#ended").get_attribute("data-outcome") == "aborted"


def test_a_run_that_comes_to_its_end_shows_its_verdict_and_a_next_one_begins_anew(
    midst: Midst, tab: Any, tmp_path: Path
) -> None:
    tab.goto(midst.server.address)
    run, attending = midst.begin(PLAN, tmp_path / "first.h5")
    midst.held.go.set()
    run.wait()
    attending.join(20)
    wait_for_text(tab, "#ended", "Done; timing audit: good.")
    wait_for_text(tab, "#where", "frame 800")
    run, attending = midst.begin(SMALL, tmp_path / "second.h5")
    run.wait()
    attending.join(20)
    wait_for_text(tab, "#where", "frame 40")
    wait_for_text(tab, "#patterns", "240 of 240 patterns counted")
    assert tab.evaluate("kinopix.points") == 40


def test_past_runs_are_shown_with_their_pictures_and_uncertainty(midst: Midst, tab: Any) -> None:
    tab.goto(midst.server.address)
    card = tab.get_by_role("button", name="before.h5")
    card.wait_for(timeout=15_000)
    assert card.locator("img").evaluate("image => image.decode().then(() => image.naturalWidth)") == 64
    card.click()
    wait_for_text(tab, "#one-facts", "0.250 px (median, one sigma)")
    assert tab.locator("#one-path").is_visible()
    assert tab.locator("#one-pictures img").evaluate("image => image.decode().then(() => image.naturalHeight)") == 36
    tab.keyboard.press("Escape")
    assert not tab.locator("#one").is_visible()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_page_fits_on_a_phone_and_is_legible_by_day_and_by_night(chromium: Any, midst: Midst, scheme: str) -> None:
    """Contrast of text by WCAG 2, 1.4.3: 4.5 to 1 at least; fields for a finger by 2.5.8: 24 px at least."""
    context = chromium.new_context(viewport={"width": 360, "height": 740}, color_scheme=scheme)
    tab = context.new_page()
    midst.page.begins(midst.instrument, PLAN)
    midst.page.board.say("at rest", offers=("check", "start", "home"), notice="a word")
    tab.goto(midst.server.address)
    wait_for_text(tab, "#devices", "simulated DLP7000")
    assert tab.evaluate("document.documentElement.scrollWidth") == 360
    assert min(box["height"] for box in (b.bounding_box() for b in tab.get_by_role("button").all())) >= 24
    assert min(tab.evaluate(CONTRASTS)) >= 4.5
    context.close()


CONTRASTS = """() => {
  const parse = (c) => { const m = c.match(/[\\d.]+/g).map(Number); return m.length < 4 ? [...m, 1] : m; };
  const linear = (v) => (v <= 0.04045 * 255 ? v / 255 / 12.92 : ((v / 255 + 0.055) / 1.055) ** 2.4);
  const light = ([r, g, b]) => 0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b);
  const ground = (e) => {
    for (; e; e = e.parentElement) {
      const c = parse(getComputedStyle(e).backgroundColor);
      if (c[3] > 0) return c;
    }
    return [255, 255, 255, 1];
  };
  const found = [];
  for (const e of document.querySelectorAll('h1, h2, p, span, li, dt, dd, b, button:not(:disabled), strong')) {
    if (!e.checkVisibility() || ![...e.childNodes].some((n) => n.nodeType === 3 && n.textContent.trim())) continue;
    const a = light(parse(getComputedStyle(e).color)), b = light(ground(e));
    found.push((Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05));
  }
  return found;
}"""
"""The contrast of every text that is seen, by WCAG 2's relative luminance."""


def test_a_page_of_another_origin_reaches_nothing(chromium: Any, midst: Midst) -> None:
    """A page that some other server gives, on this very machine, tries everything that a script can."""
    context = chromium.new_context()
    tab = context.new_page()
    elsewhere = "http://elsewhere.example/"

    def answer(route: Any) -> None:
        route.fulfill(body="<p>elsewhere</p>", content_type="text/html")

    context.route(elsewhere, answer)
    tab.goto(elsewhere)
    here = midst.server.address
    tried = """async (here) => {
      const asked = (thing, well, badly) => new Promise((done) => {
        thing[well] = () => done('reached');
        thing[badly] = () => done('refused');
      });
      const picture = new Image();
      picture.src = here + 'page/icon.svg';
      return Promise.all([
        asked(new WebSocket(here.replace('http', 'ws') + 'live'), 'onopen', 'onerror'),
        fetch(here + 'api/recordings').then(() => 'reached', () => 'refused'),
        asked(picture, 'onload', 'onerror'),
      ]);
    }"""
    assert tab.evaluate(tried, here) == ["refused", "refused", "refused"]
    context.close()


def test_without_the_server_the_page_says_so_and_comes_back(chromium: Any) -> None:
    board = Board("first")
    context = chromium.new_context()
    tab = context.new_page()
    with PageServer(board, port=0) as server:
        tab.goto(server.address)
        wait_for_text(tab, "#title", "first")
        board(ImageEvent(frame=1, image=np.eye(8)))
        port = server.port
    tab.locator("#banner", has_text="No connection").wait_for(timeout=15_000)
    with PageServer(Board("second"), port=port):
        wait_for_text(tab, "#title", "second")
        tab.locator("#banner").wait_for(state="hidden", timeout=15_000)
    context.close()
