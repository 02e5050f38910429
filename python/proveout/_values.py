"""Values of a scene as TOML."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping, Sequence
from typing import Union

from .errors import InputError

Value = Union[None, bool, int, float, str, os.PathLike[str], Sequence["Value"], Mapping[str, "Value"]]


def document(key: str, value: Value) -> str:
    """``value = ...`` as TOML; empty for ``None``."""
    return "" if value is None else f"value = {_text(key, value)}"


def split(values: Mapping[str, Value]) -> tuple[list[str], dict[str, Value]]:
    """Values that a run sets by itself, as ``KEY=VALUE``, and those (lists, tables, nothing) that need their own copy of the scene."""
    plain = {key: value for key, value in values.items() if isinstance(value, bool | int | float | str | os.PathLike)}
    rest = {key: value for key, value in values.items() if key not in plain}
    return [f"{key}={_text(key, value)}" for key, value in plain.items()], rest


def _text(key: str, value: Value) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str | os.PathLike):
        # Text may be a path relative to the scene; a path object is relative to the current folder.
        text = value if isinstance(value, str) else os.path.abspath(value)
        # A string of JSON is one of TOML, but for the delete character.
        return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{json.dumps(k)} = {_text(f'{key}.{k}', v)}" for k, v in value.items()) + "}"
    if isinstance(value, Sequence):
        return "[" + ", ".join(_text(key, item) for item in value) + "]"
    try:
        number = float(value) if not isinstance(value, int) else value  # type: ignore[arg-type]
    except (TypeError, ValueError):
        raise InputError(f"{key}: {value!r} is not a valid value of a scene") from None
    if not math.isfinite(number):
        raise InputError(f"{key}: {number} is not a finite number")
    return repr(number)
