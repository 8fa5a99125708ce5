# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Outcomes of calls and what is raised."""

from typing import NamedTuple


class Error(RuntimeError):
    """A cloud could not be encoded, or a recording not be read or written.

    Arguments and settings that are wrong raise ValueError or TypeError instead, and memory
    that runs out MemoryError.

    Attributes
    ----------
    code : str
        The kind of failure, e.g. "InvalidInput".
    """

    def __init__(self, message: str, code: str = ""):
        super().__init__(message)
        self.code = code


class Status(NamedTuple):
    """Outcome of a call that does not raise.

    Attributes
    ----------
    code : str
        "Ok", or the kind of failure: "EndOfStream", "NoFrame", "UnsupportedVersion",
        "Truncated", "Corrupt", "LimitExceeded", "MissingReference", "OldFrame",
        "OutOfMemory"; of a recording also "InputFailed"; of an outlier removal
        "UnsupportedResolution", "NoDensities" or "NoImage"; of a temporal filter
        "HasPointCounts".
    message : str
        What is wrong, and often the remedy. A success may have a message, too.
    """

    code: str = "Ok"
    message: str = ""

    @property
    def ok(self) -> bool:
        """True for a success."""
        return self.code == "Ok"
