"""Results as frozen trees: attributes are the keys of the JSON."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any


def frozen(value: Any) -> Any:
    """A value of JSON as it is shown: objects as Records, lists as tuples."""
    if isinstance(value, dict):
        return Record(value)
    if isinstance(value, list):
        return tuple(frozen(part) for part in value)
    return value


def thawed(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: thawed(part) for key, part in value.items()}
    if isinstance(value, (list, tuple)):
        return [thawed(part) for part in value]
    return value


class Record(Mapping[str, Any]):
    """An object of the JSON: its keys are attributes and items. It cannot be changed.

    Keys that are no names are items alone, with text or number: ``difference.abs_percentiles[95]``.
    """

    __slots__ = ("_data",)
    _data: dict[str, Any]

    def __init__(self, data: Mapping[str, Any]) -> None:
        object.__setattr__(self, "_data", dict(data))

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        data = object.__getattribute__(self, "_data")
        if name not in data:
            raise AttributeError(f"{type(self).__name__} has no {name!r}: it has {', '.join(data)}")
        return frozen(data[name])

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"{type(self).__name__} cannot be changed")

    def __delattr__(self, name: str) -> None:
        raise AttributeError(f"{type(self).__name__} cannot be changed")

    def __getitem__(self, key: str | int) -> Any:
        return frozen(self._data[str(key)])

    def __iter__(self) -> Iterator[str]:
        return iter(self._data)

    def __len__(self) -> int:
        return len(self._data)

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *(key for key in self._data if key.isidentifier())})

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Record) and self._data == other._data

    def __hash__(self) -> int:
        return hash(repr(self._data))

    def __reduce__(self) -> tuple[Any, ...]:
        return Record, (self._data,)

    def __repr__(self) -> str:
        return "Record(" + ", ".join(f"{key}={_brief(value)}" for key, value in self._data.items()) + ")"

    def to_dict(self) -> dict[str, Any]:
        """A copy as plain dictionaries and lists."""
        copy: dict[str, Any] = thawed(self._data)
        return copy


def _brief(value: Any) -> str:
    if isinstance(value, dict):
        return "{…}"
    if isinstance(value, list) and len(value) > 4:
        return f"[{len(value)} values]"
    return repr(value)
