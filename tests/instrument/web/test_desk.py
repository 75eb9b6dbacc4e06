"""Wishes wait in their order; to stop goes before all others."""

from threading import Thread

from instrument.web.desk import Desk


def test_wishes_are_taken_in_their_order_and_to_stop_takes_the_others_back() -> None:
    desk = Desk()
    assert desk.take(0.0) is None
    assert desk.ask("check")
    assert desk.ask("start")
    assert [desk.take(0.0), desk.take(0.0), desk.take(0.0)] == ["check", "start", None]
    desk.ask("check")
    desk.ask("start")
    desk.ask("stop")
    assert [desk.take(0.0), desk.take(0.0)] == ["stop", None]


def test_eight_wishes_wait_and_a_ninth_is_not_taken_but_to_stop_always_is() -> None:
    desk = Desk()
    assert [desk.ask("check") for _ in range(9)] == [True] * 8 + [False]
    assert desk.ask("stop")
    assert desk.take(0.0) == "stop"


def test_who_waits_is_woken_by_a_wish() -> None:
    desk, got = Desk(), list[object]()
    waiting = Thread(target=lambda: got.append(desk.take(20.0)))
    waiting.start()
    desk.ask("home")
    waiting.join(5)
    assert got == ["home"]
