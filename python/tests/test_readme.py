# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""The examples of the README run as they stand."""

import pathlib
import re

import pytest

README = pathlib.Path(__file__).parents[1] / "README.md"
EXAMPLES = re.findall(r"^```python\n(.*?)^```", README.read_text(), re.M | re.S)


def test_there_are_seven():
    assert len(EXAMPLES) == 7


@pytest.mark.parametrize("number", range(7))
def test_example(number, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    exec(compile(EXAMPLES[number], f"example {number}", "exec"), {})
    printed = capsys.readouterr().out
    assert printed
    if number == 2:
        assert "'time', 'ring') True\n" in printed
    if number == 3:
        removed, kept = re.findall(r"\d+", printed)
        assert int(removed) > 30 and int(kept) > 5000
    if number == 4:
        assert printed.count("/sensor_") >= 20
    if number == 5:
        assert printed.count("points at") == 10
        assert pathlib.Path("cloud.png").stat().st_size > 10000
    if number == 6:
        assert re.fullmatch(r"2 MissingReference .*\n", printed)
