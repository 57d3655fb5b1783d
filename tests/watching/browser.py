"""A headless Chromium, driven by its debugging protocol."""

import json
import shutil
import subprocess
import time

import pytest
import websocket


class Browser:
    """One tab. said: what went wrong in it, as its console and its log have it."""

    def __init__(self, profile):
        program = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
        if program is None:
            pytest.skip("no Chromium is installed to open the page with")
        command = [
            program,
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--no-proxy-server",
            "--remote-debugging-port=0",
            f"--user-data-dir={profile}",
            "about:blank",
        ]
        self._process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self._number, self.said = 0, []
        port, path = until(
            lambda: (profile / "DevToolsActivePort").is_file() and (profile / "DevToolsActivePort").read_text().split(), lambda found: len(found or ()) == 2
        )
        self._socket = websocket.create_connection(f"ws://127.0.0.1:{port}{path}", suppress_origin=True, timeout=60)
        self._session = None
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log"):
            self.call(f"{domain}.enable")

    def call(self, method, **parameters):
        """What a method of the protocol returns; what is told meanwhile is noted."""
        self._number += 1
        self._socket.send(json.dumps({"id": self._number, "method": method, "params": parameters} | ({"sessionId": self._session} if self._session else {})))
        while True:
            told = json.loads(self._socket.recv())
            if told.get("id") == self._number:
                assert "error" not in told, told
                return told["result"]
            self._note(told)

    def evaluate(self, expression):
        """The value of an expression in the page."""
        found = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in found, found
        return found["result"].get("value")

    def until(self, expression, holds=bool):
        """The value of an expression, once it is as it is to be."""
        return until(lambda: self.evaluate(expression), holds)

    def close(self):
        self._socket.close()
        self._process.terminate()
        self._process.wait(20)

    def _note(self, told):
        about = told.get("params", {})
        if told.get("method") == "Runtime.exceptionThrown" or (told.get("method") == "Log.entryAdded" and about["entry"]["level"] == "error"):
            self.said.append(json.dumps(about))
        if told.get("method") == "Runtime.consoleAPICalled" and about["type"] in ("error", "assert"):
            self.said.append(json.dumps(about))


def until(look, holds, seconds=60):
    """What a look finds, once it is as it is to be."""
    deadline = time.monotonic() + seconds
    while not holds(found := look()):
        assert time.monotonic() < deadline, f"after {seconds} s it is {found}"
        time.sleep(0.1)
    return found
