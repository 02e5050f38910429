"""Exceptions with place and remedy."""

from __future__ import annotations

__all__ = ["ControlError", "FolderError", "InputError", "InternalError", "ProgramError", "ProveoutError"]


class ProveoutError(Exception):
    """Base of all errors of this package.

    ``str()`` of it is the text printed by the command line: message, place, source line, remedy.
    """

    message: str
    """What is wrong, in one sentence."""
    file: str | None
    """The file that contains the fault, if any."""
    line: int | None
    """Its line, from 1."""
    column: int | None
    """Its column in characters, from 1."""
    remedy: str
    """How to fix it; may be empty."""

    def __init__(
        self,
        message: str,
        *,
        file: str | None = None,
        line: int | None = None,
        column: int | None = None,
        remedy: str = "",
        text: str = "",
    ) -> None:
        super().__init__(message)
        self.message = message
        self.file = file
        self.line = line
        self.column = column
        self.remedy = remedy
        self._text = text.strip().removeprefix("error: ") or (f"{message}\n  help: {remedy}" if remedy else message)

    @property
    def place(self) -> str | None:
        """``file:line:column``, as far as it is known."""
        if self.file is None:
            return None
        return ":".join(str(part) for part in (self.file, self.line, self.column) if part is not None)

    def __str__(self) -> str:
        return self._text


class InputError(ProveoutError, ValueError):
    """Invalid argument or input file: scene, machine, tool library, mesh, control file."""


class ProgramError(ProveoutError):
    """Error in the text of an NC program."""


class ControlError(ProveoutError):
    """A program that the control cannot execute."""


class FolderError(ProveoutError, OSError):
    """A folder or file that cannot be written."""


class InternalError(ProveoutError):
    """An internal error of Proveout, not an error in the input."""

    def __init__(self, message: str) -> None:
        super().__init__(
            f"internal error: {message}",
            remedy="please report it with the scene and the NC program that caused it",
        )
