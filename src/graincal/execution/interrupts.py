"""Ctrl-C, at a moment when it would leave something behind."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def sigint_later() -> Iterator[None]:
    """What Ctrl-C means here it means at the end: broken off in between, a process would live on of which nobody knows.

    A process that is begun meanwhile does not hear Ctrl-C until it asks to: what it means is the owner's affair.
    """
    # Blocked in this thread, whose mask a process inherits, it still reaches the owner by another thread.
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    # Handlers run in the main thread, and can be set there alone.
    handler = signal.getsignal(signal.SIGINT) if threading.current_thread() is threading.main_thread() else None
    heard: list[tuple[int, FrameType | None]] = []
    if callable(handler):
        signal.signal(signal.SIGINT, lambda *arguments: heard.append(arguments))
    try:
        yield
    finally:
        if callable(handler):
            signal.signal(signal.SIGINT, handler)
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
        if heard:
            handler(*heard[0])
