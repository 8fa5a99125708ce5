# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""How far a call is that takes long."""

from __future__ import annotations

import contextlib
from typing import Callable, Iterator, Optional, Union

from ._points import package

Report = Callable[[int, Optional[int]], object]
Progress = Union[bool, Report]


@contextlib.contextmanager
def reporting(progress: Progress) -> Iterator[Optional[Report]]:
    """The function that takes what is done and how much there is, while a call lasts.

    Parameters
    ----------
    progress : bool or callable
        The caller's function; True: a bar of tqdm; False: none.
    """
    if progress is False:
        yield None
    elif progress is True:
        with package("tqdm.auto", "python3-tqdm").tqdm() as bar:

            def report(done: int, total: Optional[int]) -> None:
                bar.total = total
                bar.update(done - bar.n)

            yield report
    elif callable(progress):
        yield progress
    else:
        raise TypeError(
            f"progress is {progress!r}; it must be True, False or a function of done and total"
        )
