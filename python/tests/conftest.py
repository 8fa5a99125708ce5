# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""What the tests of the package share."""

import os

import numpy as np
import pytest

# The programs are built with PCL only; without, there is nothing to compare with or to run.
collect_ignore = [
    test
    for variable, test in (
        ("PCL_EXT_ENCODE_WITH_PCL", "test_bytes_of_cpp.py"),
        ("PCL_EXT_PROGRAM", "test_bags.py"),
        ("PCL_EXT_PROGRAM", "test_notebook.py"),
    )
    if variable not in os.environ
]


@pytest.fixture
def random():
    return np.random.default_rng(14)


@pytest.fixture
def room(random):
    """A cloud of two walls and clutter, float32, 3 m wide, in front of a camera."""
    wall = np.column_stack(
        (random.uniform(-1.5, 1.5, 4000), random.uniform(-1, 1, 4000), np.full(4000, 2.5))
    )
    side = np.column_stack(
        (np.full(2000, 1.5), random.uniform(-1, 1, 2000), random.uniform(0.5, 2.5, 2000))
    )
    clutter = random.uniform((-1.5, -1, 0.5), (1.5, 1, 2.5), (500, 3))
    return np.vstack((wall, side, clutter)).astype(np.float32)
