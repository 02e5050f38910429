"""Progress of a run, on standard error."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

Progress = Callable[[float, str], object]

# Where standard error is no terminal, a line comes so often.
LINE_EVERY_S = 10.0


class Printer:
    """One line that is written over on a terminal, a line now and then elsewhere."""

    def __init__(self) -> None:
        self._terminal = sys.stderr.isatty()
        self._width = 0
        self._last = time.monotonic()

    def __call__(self, share: float, text: str) -> None:
        line = f"{100 * share:3.0f} %  {text}"
        if self._terminal:
            end = "\n" if share >= 1 else ""
            print(f"\r{line:<{self._width}}", end=end, file=sys.stderr, flush=True)
            self._width = len(line)
        elif time.monotonic() - self._last > LINE_EVERY_S:
            self._last = time.monotonic()
            print(line, file=sys.stderr, flush=True)


def printer(progress: bool | Progress) -> Progress | None:
    """What is called with a share from 0 to 1 and a text."""
    if callable(progress):
        return progress
    return Printer() if progress else None
