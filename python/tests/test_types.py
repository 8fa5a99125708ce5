# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Types of the package, its stub, its examples and those of the README, by mypy."""

import pathlib
import subprocess
import sys

import pytest
from test_readme import EXAMPLES

ROOT = pathlib.Path(__file__).parents[2]

WRONG = """
import pcl_ext
encoder = pcl_ext.Encoder(effort='great')
frame: str = encoder.encode([[0.0, 0.0, 0.0]])
pcl_ext.encode_bag('a', 'b', progress=lambda done: None)
"""


def test_what_is_wrong_is_found_and_nothing_else(tmp_path):
    pytest.importorskip("mypy")
    paths = [tmp_path / f"example_{number}.py" for number in range(len(EXAMPLES))]
    for path, example in zip(paths, EXAMPLES):
        # Frames that are lost are the matter of one of them only.
        path.write_text("# mypy: strict_optional=False\n" + example)
    wrong = tmp_path / "wrong.py"
    wrong.write_text(WRONG)
    command = [sys.executable, "-m", "mypy", "--cache-dir", tmp_path / "cache"]
    command += ["python/pcl_ext", "python/examples", *paths, wrong]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 1, done.stderr
    errors = [line for line in done.stdout.splitlines() if ": error: " in line]
    places = [line.partition(": error: ")[0] for line in errors]
    assert list(dict.fromkeys(places)) == [f"{wrong}:{number}" for number in (3, 4, 5)], done.stdout
