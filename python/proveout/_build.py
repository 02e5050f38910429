"""Frozen dataclasses from the JSON files of a run."""

from __future__ import annotations

import dataclasses
import types
import typing
from collections.abc import Mapping
from typing import Any, TypeVar, Union

from .errors import InputError

T = TypeVar("T")


_known: dict[type, dict[str, tuple[Any, bool]]] = {}


def _fields(cls: type) -> dict[str, tuple[Any, bool]]:
    """Type of each field, and whether it has a default."""
    if cls in _known:
        return _known[cls]
    hints = typing.get_type_hints(cls)
    missing = dataclasses.MISSING
    _known[cls] = {
        field.name: (hints[field.name], field.default is not missing or field.default_factory is not missing)
        for field in dataclasses.fields(cls)
    }
    return _known[cls]


def build(cls: type[T], data: Any) -> T:
    """An instance of a dataclass; unknown keys are ignored, so that files of a later version can be read."""
    if not isinstance(data, Mapping):
        raise InputError(f"{cls.__name__}: a table is expected, not {type(data).__name__}")
    values = {}
    for name, (hint, has_default) in _fields(cls).items():
        if name in data:
            values[name] = _value(hint, data[name])
        elif not has_default:
            raise InputError(f"{cls.__name__}: the key {name!r} is missing", remedy="run the scene again")
    return cls(**values)


def _value(hint: Any, data: Any) -> Any:
    if hint is Any:
        return data
    origin, arguments = typing.get_origin(hint), typing.get_args(hint)
    if origin in (Union, types.UnionType):
        if data is None:
            return None
        return _value(next(a for a in arguments if a is not type(None)), data)
    if origin is tuple:
        if len(arguments) == 2 and arguments[1] is Ellipsis:
            return tuple(_value(arguments[0], item) for item in data)
        return tuple(_value(a, item) for a, item in zip(arguments, data, strict=True))
    if origin in (dict, Mapping) or origin is typing.get_origin(Mapping[str, Any]):
        return types.MappingProxyType({key: _value(arguments[1], item) for key, item in data.items()})
    if dataclasses.is_dataclass(hint) and isinstance(hint, type):
        return build(hint, data)
    if isinstance(hint, type) and hint not in (int, float, str, bool, object):
        return hint(data)
    return float(data) if hint is float else data
