# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""What an object is, in a line."""

from __future__ import annotations

import inspect
import reprlib
from typing import Any, Mapping


def counted(count: int, noun: str) -> str:
    """A number of things: "1 frame", "1,234 frames"."""
    return f"{count:,} {noun}" + ("" if count == 1 else "s")


def call_of(thing: object, settings: Mapping[str, Any]) -> str:
    """The call that makes such an object: its class with the settings that are not the
    defaults."""
    usual = inspect.signature(type(thing).__init__).parameters
    words = [
        f"{name}={shown(value)}"
        for name, value in settings.items()
        if name in usual and shown(value) != shown(usual[name].default)
    ]
    return f"{type(thing).__name__}({', '.join(words)})"


def in_a_line(values: Any) -> str:
    """A named tuple, with its bytes as their number."""
    words = [
        f"{name}=<{counted(len(value), 'byte')}>"
        if isinstance(value, bytes)
        else f"{name}={shown(value)}"
        for name, value in zip(values._fields, values)
    ]
    return f"{type(values).__name__}({', '.join(words)})"


def shown(value: Any) -> str:
    """A value in a short line, for messages, too."""
    text = reprlib.Repr()
    text.maxstring = text.maxother = 60
    try:
        return " ".join(text.repr(value).split())
    except ValueError:  # of a whole number of thousands of digits
        return f"an object of type {type(value).__name__}"
