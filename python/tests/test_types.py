# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Types of the package, its stub, its examples and those of the README, by mypy."""

import pathlib
import re
import subprocess
import sys

import pytest
from test_readme import EXAMPLES

ROOT = pathlib.Path(__file__).parents[2]

WRONG = """
import pcl_ext
encoder = pcl_ext.Encoder(effort='great')
frame: str = encoder.encode([[0.0, 0.0, 0.0]])
def show(done: int) -> None: ...
pcl_ext.encode_bag('a', 'b', progress=show)
"""
WRONG_LINES = {3: "arg-type", 4: "assignment", 6: "arg-type"}


def test_what_is_wrong_is_found_and_nothing_else(tmp_path):
    pytest.importorskip("mypy")
    paths = [tmp_path / f"example_{number}.py" for number in range(len(EXAMPLES))]
    for path, example in zip(paths, EXAMPLES):
        # Frames that are lost are the matter of one of them only.
        path.write_text("# mypy: strict_optional=False\n" + example)
    wrong = tmp_path / "wrong.py"
    wrong.write_text(WRONG)
    command = [sys.executable, "-m", "mypy", "--cache-dir", tmp_path / "cache"]
    # Which ignored errors there are depends on the versions of mypy and of numpy.
    command += ["--no-warn-unused-ignores", "--show-error-codes", "--no-pretty"]
    command += ["python/pcl_ext", "python/examples", *paths, wrong]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 1, done.stderr
    found = re.findall(r"^(.*?:\d+)(?::\d+)?: error: .*\[([a-z-]+)\]$", done.stdout, re.MULTILINE)
    assert len(found) == done.stdout.count(": error: "), done.stdout
    expected = {(f"{wrong}:{number}", code) for number, code in WRONG_LINES.items()}
    assert set(found) == expected, done.stdout
