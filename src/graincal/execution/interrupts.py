"""Ctrl-C and other signals to end, at a moment when it would leave something behind."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
"""Signals that ask a process to end: Ctrl-C, a batch system, a logout."""


@contextmanager
def interrupts_later() -> Iterator[None]:
    """What a signal to end means here it means at the end: broken off in between, a process would live on of which nobody knows.

    A process that is begun meanwhile does not hear these signals until it asks to: what they mean is the owner's affair.
    """
    # Blocked in this thread, whose mask a process inherits, they still reach the owner by another thread.
    before = signal.pthread_sigmask(signal.SIG_BLOCK, ENDING)
    # Handlers run in the main thread, and can be set there alone.
    in_main = threading.current_thread() is threading.main_thread()
    handlers = {number: handler for number in ENDING if in_main and callable(handler := signal.getsignal(number))}
    heard: list[tuple[int, FrameType | None]] = []
    for number in handlers:
        signal.signal(number, lambda *arguments: heard.append(arguments))
    try:
        yield
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
        if heard:
            handlers[signal.Signals(heard[0][0])](*heard[0])
