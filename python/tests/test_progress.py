# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""How far calls are that take long: Recording.clouds; encode_bag's is in test_bags.py."""

import builtins
import sys

import pytest

import pcl_ext


@pytest.fixture
def recording(room, tmp_path):
    path = tmp_path / "cell.mcap"
    with pcl_ext.RecordingWriter(path) as writer:
        for name, period in (("/often", 0.1), ("/seldom", 0.3)):
            stream, encoder = writer.add_stream(name), pcl_ext.Encoder(0.1)
            for number in range(round(0.9 / period)):
                writer.append(stream, encoder.encode(room), 10 + number * period)
    with pcl_ext.open(path) as opened:
        yield opened


def test_frames_are_counted_before_each_is_decoded(recording):
    calls = []
    seen = 0
    for _ in recording.clouds(progress=lambda *numbers: calls.append(numbers)):
        assert calls[-1] == (seen, 12)
        seen += 1
    assert calls == [(done, 12) for done in range(13)]


def test_those_of_other_streams_and_times_do_not_count(recording):
    calls = []

    def add(done, total):
        calls.append((done, total))

    given = list(recording.clouds("/often", start=10.15, end=10.65, progress=add))
    assert calls == [(done, len(given)) for done in range(len(given) + 1)]
    assert len(given) == 5
    calls.clear()
    assert list(recording.clouds(start=99.0, progress=add)) == []
    assert calls == [(0, 0)]


def test_what_a_function_raises_ends_the_iteration(recording):
    def stop(done, total):
        if done == 3:
            raise KeyError("enough")

    clouds = recording.clouds(progress=stop)
    assert len([next(clouds) for _ in range(3)]) == 3
    with pytest.raises(KeyError, match="enough"):
        next(clouds)


def test_a_bar_of_tqdm(recording, capsys):
    pytest.importorskip("tqdm")
    assert len(list(recording.clouds(progress=True))) == 12
    assert "12/12" in capsys.readouterr().err
    # One that ends early says where.
    clouds = recording.clouds(progress=True)
    for _ in range(5):
        next(clouds)
    clouds.close()
    assert "4/12" in capsys.readouterr().err


def test_without_tqdm_the_package_is_named(recording, monkeypatch):
    for name in [name for name in sys.modules if name.partition(".")[0] == "tqdm"]:
        monkeypatch.delitem(sys.modules, name)
    usual = builtins.__import__

    def without_tqdm(name, *arguments, **named):
        if name.partition(".")[0] == "tqdm":
            raise ModuleNotFoundError("No module named 'tqdm'", name="tqdm")
        return usual(name, *arguments, **named)

    monkeypatch.setattr("builtins.__import__", without_tqdm)
    monkeypatch.setattr("sys.path", [])
    monkeypatch.setattr("sys.path_importer_cache", {})
    with pytest.raises(ImportError, match="tqdm is missing: pip install tqdm, or Debian's p"):
        next(recording.clouds(progress=True))


@pytest.mark.parametrize("progress", [1, None, "yes"])
def test_other_values_are_refused(recording, progress):
    with pytest.raises(TypeError, match=f"progress is {progress!r}; it must be True, False"):
        next(recording.clouds(progress=progress))
