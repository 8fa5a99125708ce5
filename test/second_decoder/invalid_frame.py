# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""The error of every frame that breaks a rule of the document."""


class InvalidFrame(Exception):
    """A frame is refused; what a decoder keeps is as it was before."""


def require(holds: bool, rule: str) -> None:
    """Refuses the frame unless a rule holds."""
    if not holds:
        raise InvalidFrame(rule)
