"""A wait that an interrupt may break: rung before or while somebody waits, it is heard once."""

from threading import Thread

from instrument.session.bell import Bell


def test_rung_before_anybody_waits_it_is_heard_once() -> None:
    bell = Bell()
    bell.ring()
    bell.ring()
    assert bell.wait(0)
    assert not bell.wait(0)


def test_whoever_waits_is_woken_by_another_thread() -> None:
    bell, heard = Bell(), list[bool]()
    waiting = Thread(target=lambda: heard.append(bell.wait(20)))
    waiting.start()
    bell.ring()
    waiting.join()
    assert heard == [True]
