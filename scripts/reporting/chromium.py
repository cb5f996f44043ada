# SPDX-License-Identifier: GPL-3.0-or-later
"""Chromium without a window, spoken to in its DevTools protocol through two pipes."""
import fcntl
import json
import os
import pathlib
import select
import shutil
import signal
import tempfile
import time

NAMES = ("chromium", "chromium-browser", "google-chrome")
OPTIONS = ("--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-extensions", "--disable-sync",
           "--disable-background-networking", "--disable-component-update", "--hide-scrollbars", "--remote-debugging-pipe")
PATIENCE = 60  # seconds that an answer may take


def find():
    """Path of the browser, None without one"""
    return next(filter(None, map(shutil.which, NAMES)), None)


def pipe():
    """(read, write), both beyond the descriptors 3 and 4, which the browser takes"""
    ends = os.pipe()
    moved = [fcntl.fcntl(end, fcntl.F_DUPFD_CLOEXEC, 10) for end in ends]
    for end in ends:
        os.close(end)
    return moved


class Chromium:
    """One page. Events are kept in `events` in the order in which they came."""

    def __init__(self, program):
        self.events, self._answers, self._buffer, self._last, self._session = [], {}, b"", 0, None
        self._profile = tempfile.TemporaryDirectory(prefix="check-report-", ignore_cleanup_errors=True)
        theirs_in, self._out = pipe()
        self._in, theirs_out = pipe()
        actions = [(os.POSIX_SPAWN_DUP2, theirs_in, 3), (os.POSIX_SPAWN_DUP2, theirs_out, 4)]
        actions += [(os.POSIX_SPAWN_OPEN, fd, os.devnull, os.O_RDWR, 0) for fd in (0, 1, 2)]
        command = [program, *OPTIONS, f"--user-data-dir={self._profile.name}", "about:blank"]
        self._process = os.posix_spawn(program, command, os.environ, file_actions=actions, setpgroup=0)
        os.close(theirs_in)
        os.close(theirs_out)

    def __enter__(self):
        try:
            target = self.call("Target.createTarget", url="about:blank")["targetId"]
            self._session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        except BaseException:
            self.close()
            raise
        return self

    def __exit__(self, *_):
        self.close()

    def call(self, method, **parameters):
        """The result; RuntimeError where the browser refuses."""
        self._last += 1
        message = {"id": self._last, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        self._write(json.dumps(message).encode() + b"\0")
        end, wanted = time.monotonic() + PATIENCE, self._last
        while wanted not in self._answers:
            self._read(end, method)
        answer = self._answers.pop(wanted)
        if "error" in answer:
            raise RuntimeError(f"{method}: {answer['error'].get('message')}")
        return answer["result"]

    def evaluate(self, script):
        """The value of a JavaScript expression, a promise awaited"""
        answer = self.call("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(f"{script[:60]}: {answer['exceptionDetails'].get('text')}")
        return answer["result"].get("value")

    def wait_for(self, method):
        end = time.monotonic() + PATIENCE
        while not any(event["method"] == method for event in self.events):
            self._read(end, method)

    def _write(self, data):
        while data:
            data = data[os.write(self._out, data):]

    def _read(self, end, waiting_for):
        """Takes in what has come."""
        if not select.select([self._in], [], [], max(0.0, end - time.monotonic()))[0]:
            raise RuntimeError(f"no answer to {waiting_for} within {PATIENCE} s")
        data = os.read(self._in, 1 << 16)
        if not data:
            raise RuntimeError("the browser has ended by itself")
        *messages, self._buffer = (self._buffer + data).split(b"\0")
        for message in map(json.loads, messages):
            if "id" in message:
                self._answers[message["id"]] = message
            else:
                self.events.append(message)

    def close(self):
        """Asks the browser to end, then makes it; the folder of its profile goes with it."""
        self._session = None
        try:
            self.call("Browser.close")
        except (RuntimeError, OSError):
            pass
        end = time.monotonic() + 5
        while os.waitpid(self._process, os.WNOHANG)[0] == 0:
            if time.monotonic() > end:
                os.killpg(self._process, signal.SIGKILL)
                os.waitpid(self._process, 0)
                break
            time.sleep(0.02)
        os.close(self._in)
        os.close(self._out)
        self._profile.cleanup()


def address(path):
    return pathlib.Path(path).resolve().as_uri()
