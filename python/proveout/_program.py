"""The program ``proveout``."""

from __future__ import annotations

import signal
import sys

from . import _proveout


def main() -> None:
    """Runs the command line; ends the process with its exit code."""
    # The program listens for Ctrl-C itself, or is ended by it.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(_proveout.call(["proveout", *sys.argv[1:]]))
