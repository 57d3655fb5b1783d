"""A page that follows a campaign of formulas, and requests to it."""

import http.client
import threading
from urllib.parse import urlsplit

import pytest
from report import soil

from graincal.watching.server import Server


class Page:
    """A server on a thread, and what it answers."""

    def __init__(self, folder, **options):
        self.server = Server(folder, **options)
        self.address = self.server.server_address[:2]
        self.token = urlsplit(self.server.link).query
        threading.Thread(target=self.server.serve_forever, kwargs={"poll_interval": 0.05}, daemon=True).start()
        self.cookie = ""

    def close(self):
        self.server.shutdown()
        self.server.server_close()

    def enter(self):
        """Take the link's token to the page, as a browser does."""
        found = self.ask(f"/?{self.token}")
        self.cookie = found.getheader("Set-Cookie").split(";")[0]
        return found

    def open(self, path, method="GET", host="localhost:8000", headers=None):
        """The answer, of which the body is not read."""
        connection = http.client.HTTPConnection(*self.address, timeout=20)
        connection.putrequest(method, path, skip_host=True)
        for name, value in ([("Host", host)] if host else []) + list((headers or {}).items()) + ([("Cookie", self.cookie)] if self.cookie else []):
            connection.putheader(name, value)
        connection.endheaders()
        return connection.getresponse()

    def ask(self, path, method="GET", **options):
        found = self.open(path, method, **options)
        found.text = found.read().decode()
        return found


@pytest.fixture(scope="session")
def campaign(tmp_path_factory):
    folder = tmp_path_factory.mktemp("watched") / "campaign"
    soil.calibrate(folder=folder)
    return folder


@pytest.fixture
def page(campaign):
    page = Page(campaign)
    yield page
    page.close()
