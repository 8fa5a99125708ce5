# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""The notebook runs from its first cell to its last."""

import base64
import json
import pathlib
import subprocess
import sys

import pytest

NOTEBOOK = pathlib.Path(__file__).parents[1] / "examples" / "bag_to_picture.ipynb"


def test_it_is_stored_without_what_a_run_left():
    cells = json.loads(NOTEBOOK.read_text())["cells"]
    assert "SPDX-License-Identifier: BSD-3-Clause" in cells[0]["source"][0]
    code = [cell for cell in cells if cell["cell_type"] == "code"]
    assert len(code) == 7
    assert all(not cell["outputs"] and cell["execution_count"] is None for cell in code)


def test_bag_to_picture(tmp_path, monkeypatch):
    for package in ("nbconvert", "ipykernel", "pandas"):
        pytest.importorskip(package)
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path))
    monkeypatch.setenv("JUPYTER_RUNTIME_DIR", str(tmp_path))
    monkeypatch.delenv("MPLBACKEND", raising=False)
    command = [sys.executable, "-m", "nbconvert", "--to", "notebook", "--execute"]
    command += [f"--ExecutePreprocessor.{name}=300" for name in ("startup_timeout", "timeout")]
    command += ["--output-dir", tmp_path, NOTEBOOK]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    cells = json.loads((tmp_path / NOTEBOOK.name).read_text())["cells"]
    outputs = [output for cell in cells for output in cell.get("outputs", ())]
    text = "".join("".join(output.get("text", ())) for output in outputs)
    # 40 clouds of 20 Hz, with an I-frame each second; and the last one as it is shown.
    assert "1 stream, 40 frames" in text and "max      1.0\n" in text, text
    assert "<Cloud of 17," in text and ", intensity 1 to " in text, text
    pictures = [
        base64.b64decode(output["data"]["image/png"])
        for output in outputs
        if "image/png" in output.get("data", {})
    ]
    assert len(pictures) == 3 and all(len(picture) > 5000 for picture in pictures)
    tables = [output for output in outputs if "text/html" in output.get("data", {})]
    assert len(tables) == 2
