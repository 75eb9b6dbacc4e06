"""Who comes in, from the heads of a request alone."""

import socket

import pytest

from instrument.web.gate import Gate
from protocols import InputError

TOKEN = "sixteen-letters!"  # noqa: S105
HERE = Gate("127.0.0.1", 8470)
FAR = Gate("0.0.0.0", 8470, TOKEN)  # noqa: S104


@pytest.mark.parametrize(
    ("host", "comes_in"),
    [
        ("127.0.0.1:8470", True),
        ("localhost:8470", True),
        ("[::1]:8470", True),
        ("127.0.0.1:8471", False),
        ("127.0.0.1", False),
        ("evil.example:8470", False),
        ("192.168.1.7:8470", False),
        ("127.0.0.1.evil.example:8470", False),
        ("user@127.0.0.1:8470", False),
        ("127.0.0.1:8470/path", False),
        ("127.0.0.1:port", False),
        ("[::1:8470", False),
        ("", False),
    ],
)
def test_only_this_machines_own_names_are_answered(host: str, *, comes_in: bool) -> None:
    """A name that somebody else made to point here is not among them: DNS rebinding."""
    refusal = HERE.refusal({"host": host})
    assert (refusal is None) == comes_in
    assert refusal is None or refusal.status == 400


@pytest.mark.parametrize(
    ("host", "status"),
    [
        ("192.168.1.7:8470", 401),
        ("[fe80::1]:8470", 401),
        (f"{socket.gethostname()}:8470", 401),
        ("evil.example:8470", 400),
        ("192.168.1.7:80", 400),
    ],
)
def test_bound_to_all_addresses_it_answers_to_addresses_and_its_own_name(host: str, status: int) -> None:
    """401: the name is right, and the token is still asked for."""
    refusal = FAR.refusal({"host": host})
    assert refusal is not None
    assert refusal.status == status


@pytest.mark.parametrize(
    ("origin", "status"),
    [
        ("http://127.0.0.1:8470", None),
        ("http://localhost:8470", 403),
        ("https://127.0.0.1:8470", 403),
        ("http://127.0.0.1:8471", 403),
        ("http://evil.example", 403),
        ("null", 403),
        ("", 403),
    ],
)
@pytest.mark.parametrize("websocket", [False, True])
def test_a_page_of_another_origin_is_refused(origin: str, status: int | None, *, websocket: bool) -> None:
    refusal = HERE.refusal({"host": "127.0.0.1:8470", "origin": origin}, websocket=websocket)
    assert (None if refusal is None else refusal.status) == status


@pytest.mark.parametrize(
    ("site", "mode", "websocket", "comes_in"),
    [
        ("same-origin", "cors", False, True),
        ("none", "navigate", False, True),
        ("cross-site", "navigate", False, True),
        ("cross-site", "no-cors", False, False),
        ("same-site", "no-cors", False, False),
        ("cross-site", "websocket", True, False),
        ("cross-site", "navigate", True, False),
    ],
)
def test_another_page_may_lead_here_but_take_nothing(site: str, mode: str, *, websocket: bool, comes_in: bool) -> None:
    heads = {"host": "127.0.0.1:8470", "sec-fetch-site": site, "sec-fetch-mode": mode}
    assert (HERE.refusal(heads, websocket=websocket) is None) == comes_in


@pytest.mark.parametrize(
    ("head", "value", "comes_in"),
    [
        ("authorization", f"Bearer {TOKEN}", True),
        ("authorization", f"bearer  {TOKEN} ", True),
        ("authorization", f"Basic {TOKEN}", False),
        ("authorization", f"Bearer {TOKEN}x", False),
        ("authorization", "Bearer ", False),
        ("authorization", "Bearer \u00e9", False),
        ("cookie", f"kinopix-8470={TOKEN}", False),
        ("cookie", "kinopix-8470=", False),
        ("cookie", "a;;=\x00", False),
        ("x-nothing", "", False),
    ],
)
def test_the_token_is_asked_for(head: str, value: str, *, comes_in: bool) -> None:
    refusal = FAR.refusal({"host": "10.0.0.1:8470", head: value})
    assert (refusal is None) == comes_in
    assert refusal is None or refusal.status == 401


def test_the_cookie_holds_a_ticket_of_this_server_and_not_the_token() -> None:
    host = {"host": "10.0.0.1:8470"}
    assert FAR.refusal(host | {"cookie": f"other=1; kinopix-8470={FAR.ticket}"}) is None
    assert FAR.refusal(host | {"cookie": f"kinopix-8471={FAR.ticket}"}) is not None
    assert TOKEN not in FAR.ticket
    assert Gate("127.0.0.1", 8470, TOKEN).ticket != FAR.ticket


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.168.1.7", "my-bench", "128.0.0.1"])  # noqa: S104
def test_an_address_that_others_reach_needs_a_token(host: str) -> None:
    with pytest.raises(InputError, match="without a token"):
        Gate(host, 8470)
    assert Gate(host, 8470, TOKEN).opens(TOKEN)


@pytest.mark.parametrize("host", ["127.0.0.1", "127.8.9.1", "::1", "localhost"])
def test_this_machines_own_address_needs_none(host: str) -> None:
    assert not Gate(host, 8470).opens("")


@pytest.mark.parametrize("token", ["", "fifteen-letters", "sixteen-l\u00e9tters!", "sixteen\nletters!"])
def test_a_token_that_is_short_or_odd_is_refused(token: str) -> None:
    with pytest.raises(InputError, match="at least 16 plain characters"):
        Gate("127.0.0.1", 8470, token)
