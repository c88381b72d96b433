"""Values of Python as the texts that the library reads, so that its rules are the only ones."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from typing import Any, Union

from orasp import _orasp

#: What an option of a method may be: ``solve(..., episodes=100, hidden=[64, 64], to_the_end=True)``.
OptionValue = Union[bool, int, float, str, Sequence[int]]

_MOST = 2**64 - 1


def text_of(value: Any) -> str:
    """A value as one would write it on the command line: ``[64, 64]`` is ``64,64``."""
    if hasattr(value, "tolist"):  # of NumPy
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return str(int(value)) if value.is_integer() and abs(value) < 2**53 else repr(value)
    if isinstance(value, (list, tuple)):
        return ",".join(text_of(item) for item in value)
    return str(value)


def whole(label: str, value: Any, least: int = 0, most: int = _MOST) -> int:
    """A whole number, or InputError with the sentence of the command line."""
    return _orasp.whole_number(label, text_of(value), least, most)


def real(label: str, value: Any, sign: str = "any") -> float:
    """A finite number; ``sign`` is any, positive or not_negative."""
    return _orasp.number(label, text_of(value), sign)


def option_texts(options: Mapping[str, Any]) -> dict[str, str]:
    """The options of a method as texts. None and, for a flag, False mean: as if it were not given."""
    return {
        name: "" if value is True else text_of(value)
        for name, value in options.items()
        if value is not None and value is not False
    }


def _plain(value: Any) -> Any:
    if hasattr(value, "tolist"):
        return value.tolist()
    raise _orasp.InputError(f"{type(value).__name__} is nothing that a problem can hold")


def json_text(content: Any) -> str:
    """JSON. NumPy's numbers and arrays are written as plain ones."""
    try:
        return json.dumps(content, ensure_ascii=False, allow_nan=False, default=_plain)
    except ValueError as error:
        if isinstance(error, _orasp.InputError):
            raise
        place = _place_of_infinity(content, "")
        raise _orasp.InputError(f"{place}: it is not a finite number" if place else str(error)) from None


def _place_of_infinity(content: Any, place: str) -> str:
    """Where the first number stands that is not finite: ``parts[2].mass``."""
    if isinstance(content, float) and not math.isfinite(content):
        return place or "the number"
    if isinstance(content, Mapping):
        inside = ((f"{place}.{key}" if place else str(key), value) for key, value in content.items())
    elif isinstance(content, (list, tuple)):
        inside = ((f"{place}[{i}]", value) for i, value in enumerate(content))
    else:
        return ""
    return next((found for where, value in inside if (found := _place_of_infinity(value, where))), "")
