"""Who is let in, and what is answered: each rule of the page's security."""

import json
import os
import re
import shutil
import socket
from urllib.parse import urlsplit

import pytest

from graincal.watching.access import Access
from graincal.watching.board import MOST_STREAMS, Board
from graincal.watching.evaluations import MOST_PRINTED

from .conftest import Page

PATHS = ["/", "/events", "/watch.js", "/page.css", "/plotly.js", "/printed/0/0", "/nothing"]


@pytest.mark.parametrize("path", PATHS)
def test_nobody_is_let_in_without_the_token(path, page):
    assert page.ask(path).status == 403
    assert page.ask(f"{path}?token=wrong").status == 403
    page.cookie = f"{page.server.access.set_cookie.split('=')[0]}=wrong"
    assert page.ask(path).status == 403


def test_the_token_becomes_a_cookie_that_no_script_reads_and_no_other_site_sends(page):
    found = page.enter()
    cookie = found.getheader("Set-Cookie")
    assert {"HttpOnly", "SameSite=Strict", "Path=/"} <= set(cookie.split("; "))
    assert page.token.removeprefix("token=") not in cookie
    assert page.token not in found.text
    assert page.ask("/").status == 200


def test_no_two_pages_have_the_same_token_and_none_takes_the_cookie_of_another(campaign, page):
    other = Page(campaign)
    other.enter()
    page.cookie = other.cookie
    assert other.token != page.token
    assert page.ask("/").status == 403
    other.close()


def test_it_listens_at_the_loopback_address(page):
    assert page.address[0] == "127.0.0.1"


@pytest.mark.parametrize("host", ["localhost", "localhost:1", "LOCALHOST:8080", "127.0.0.1:65535", "[::1]", "[::1]:99"])
def test_this_machine_may_be_named_with_any_port(host, page):
    page.enter()
    assert page.ask("/", host=host).status == 200


@pytest.mark.parametrize(
    "host", ["", "example.org", "localhost.example.org", "127.0.0.1.example.org:80", "192.168.0.7", "[::2]", "localhost:80:80", "localhost@example.org", "::1"]
)
def test_other_hosts_are_refused_even_with_the_token(host, page):
    assert page.ask(f"/?{page.token}", host=host).status == 403
    page.enter()
    assert page.ask("/", host=host).status == 403


def test_two_hosts_are_none(page):
    page.enter()
    assert page.ask("/", headers={"host": "localhost"}).status == 403


def test_an_address_of_the_users_own_is_a_host_and_no_other_name_is():
    assert Access("192.168.0.7").knows_host(["192.168.0.7:80"])
    assert not Access("192.168.0.7").knows_host(["192.168.0.8:80"])
    everywhere = Access("0.0.0.0")
    assert everywhere.knows_host(["10.0.0.1:80"])
    assert not everywhere.knows_host(["example.org:80"])


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "PATCH", "OPTIONS", "TRACE", "CONNECT", "ODD"])
def test_only_get_and_head_are_answered(method, page):
    page.enter()
    found = page.ask("/", method)
    assert (found.status, found.getheader("Allow")) == (405, "GET, HEAD")


def test_head_has_no_body(page):
    page.enter()
    for path in ("/", "/events", "/plotly.js"):
        assert (page.ask(path, "HEAD").status, page.ask(path, "HEAD").text) == (200, "")


def test_no_script_of_the_page_stands_in_it_and_the_policy_refuses_such(page):
    page.enter()
    found = page.ask("/")
    policy = dict(rule.strip().split(" ", 1) for rule in found.getheader("Content-Security-Policy").split(";"))
    assert policy["default-src"] == "'none'"
    assert policy["script-src"] == "'self'"
    assert not re.search(r"<script(?![^>]*\bsrc=)|\son[a-z]+=|javascript:", found.text)
    assert (found.getheader("X-Content-Type-Options"), found.getheader("Referrer-Policy"), found.getheader("Cache-Control")) == (
        "nosniff",
        "no-referrer",
        "no-store",
    )


def test_sixteen_streams_and_no_more(page):
    page.enter()
    streams = [page.open("/events") for _ in range(MOST_STREAMS)]
    assert MOST_STREAMS == 16
    assert all(each.status == 200 for each in streams)
    # Each has begun once something of it is read.
    assert all(each.readline() for each in streams)
    assert page.ask("/events").status == 503


def test_a_stream_tells_the_state_the_evaluations_and_the_figures(page):
    page.enter()
    stream, told = page.open("/events"), {}
    while not {"status", "evaluations", "responses", "convergence", "samples", "latest"} <= set(told):
        kind, line = stream.readline().decode().split(), stream.readline().decode()
        stream.readline()
        news = json.loads(line.removeprefix("data: "))
        told[news["name"] if kind[1] == "figure" else kind[1]] = news
        assert not (kind[1] == "trouble" and news["text"]), news
    assert told["status"]["state"] == "finished"
    assert told["evaluations"]["total"] == told["status"]["evaluations"] == len(told["evaluations"]["rows"])
    failed = [each for each in told["evaluations"]["rows"] if each["state"] == "failed"]
    assert len(failed) == told["status"]["failures"] > 0
    assert "no <equilibrium> was found" in failed[0]["error"]


@pytest.fixture
def kept(campaign, tmp_path):
    """A page of a campaign that has files of sample 3, and the folder of its attempt."""
    folder = tmp_path / "campaign"
    shutil.copytree(campaign, folder)
    attempt = folder / "evaluations" / "00003" / "attempt-1"
    attempt.mkdir(parents=True)
    (attempt.parent / "attempt-0").mkdir()
    page = Page(folder)
    page.enter()
    yield page, attempt
    page.close()


def test_what_was_printed_is_escaped_and_printable(kept):
    page, attempt = kept
    (attempt / "printed.txt").write_bytes(b"<script>alert(1)</script> \x1b[31mred\x1b[0m \x1b]0;title\x07 \xff\n\xe2\x80\xae back\nend\n")
    found = page.ask("/printed/3/0")
    assert found.status == 200
    assert "&lt;script&gt;alert(1)&lt;/script&gt; red \\x1b]0;title\\x07" in found.text
    assert "<script" not in found.text
    assert not {"\x1b", "\u202e", "\x07"} & set(found.text)


def test_of_what_was_printed_the_last_64_kib_are_shown(kept):
    page, attempt = kept
    (attempt / "printed.txt").write_text("first" + "x" * MOST_PRINTED)
    found = page.ask("/printed/3/0")
    assert MOST_PRINTED == 65536
    assert "first" not in found.text
    assert found.text.count("x" * MOST_PRINTED) == 1


@pytest.mark.parametrize("where", ["file", "attempt", "evaluation", "evaluations"])
def test_no_link_is_followed(where, kept, tmp_path):
    page, attempt = kept
    elsewhere = tmp_path / "elsewhere"
    secret = elsewhere / {"file": "", "attempt": "", "evaluation": "attempt-1", "evaluations": "00003/attempt-1"}[where] / "printed.txt"
    secret.parent.mkdir(parents=True, exist_ok=True)
    secret.write_text("secret")
    link = {"file": attempt / "printed.txt", "attempt": attempt, "evaluation": attempt.parent, "evaluations": attempt.parent.parent}[where]
    if link.is_dir():
        shutil.rmtree(link)
    link.symlink_to(secret if where == "file" else elsewhere)
    found = page.ask("/printed/3/0")
    assert found.status == 404
    assert "secret" not in found.text


def test_a_pipe_in_the_place_of_the_file_keeps_nobody_waiting(kept):
    page, attempt = kept
    os.mkfifo(attempt / "printed.txt")
    assert page.ask("/printed/3/0").status == 404


@pytest.mark.parametrize(
    "path",
    [
        "/printed/3",
        "/printed/-3/0",
        "/printed/3/7",
        "/printed/..%2f..%2fetc/0",
        "/printed/3/0/../../log.txt",
        "/printed/%33/0",
        "/campaign.db",
        "/../campaign.db",
        "/log.txt",
        "//etc/passwd",
    ],
)
def test_evaluations_are_named_by_their_numbers_and_nothing_by_its_path(path, kept):
    page, attempt = kept
    (attempt / "printed.txt").write_text("printed")
    assert page.ask(path).status == 404


def test_what_is_forgotten_is_told_to_nobody():
    board = Board()
    board.put("figure latest", 1)
    board.put("status", 2)
    board.forget("figure")
    board.put("figure samples", 3)
    assert board.since(0, 0)[1] == [("status", "2"), ("figure samples", "3")]


def test_the_link_of_a_page_at_every_address_has_the_machines_name(campaign):
    page = Page(campaign, host="0.0.0.0")
    link = urlsplit(page.server.link)
    assert link.hostname == socket.gethostname().lower() and page.server.access.knows_host([link.netloc])
    page.close()
