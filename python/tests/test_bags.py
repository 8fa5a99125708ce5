# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Bags that the program encodes, alone and on workers of Dask."""

import importlib.util
import os
import pathlib
import pickle
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import pcl_ext

PROGRAM = os.environ["PCL_EXT_PROGRAM"]
EXAMPLE = pathlib.Path(__file__).parents[1] / "examples" / "encode_bags_with_dask.py"


def make_bag(path, room, frames):
    """A bag with clouds of two topics."""
    recording = path.with_name(f"frames_of_{path.name}")
    with pcl_ext.RecordingWriter(recording) as writer:
        for topic in ("/front", "/rear"):
            encoder = pcl_ext.Encoder(0.02, law="none")
            stream = writer.add_stream(topic)
            for number in range(frames):
                cloud = room + np.float32(0.01 * number)
                writer.append(stream, encoder.encode(cloud), float(number))
    subprocess.run([PROGRAM, "decode", "-q", recording, "-o", path], check=True)
    recording.unlink()


@pytest.fixture
def bags(room, tmp_path):
    folder = tmp_path / "bags"
    folder.mkdir()
    for number in range(4):
        make_bag(folder / f"drive_{number}.mcap", room, 3 + number)
    return folder


def test_a_summary_that_can_be_pickled(bags, tmp_path):
    encode = pickle.loads(pickle.dumps(pcl_ext.encode_bag))
    made = tmp_path / "x.mcap"
    summary = encode(bags / "drive_2.mcap", made, jobs=2, resolution=0.05, law="none")
    assert pickle.loads(pickle.dumps(summary)) == summary
    (bag,) = summary.bags
    assert summary.ok and bag.status == "done" and bag.errors == summary.errors == ()
    assert bag.inputs == (str(bags / "drive_2.mcap"),) and bag.output == str(made)
    assert [(one.name, one.frames) for one in bag.streams] == [("/front", 5), ("/rear", 5)]
    with pcl_ext.open(made) as recording:
        frames = [len(frame.data) for frame in recording]
    assert (summary.frames, summary.bytes) == (10, sum(frames)) == (10, bag.bytes)
    with pytest.raises(AttributeError):
        bag.frames = 3


@pytest.fixture
def echo(tmp_path):
    """A program that fails with its arguments as message."""
    program = tmp_path / "program"
    program.write_text("#!/bin/sh\nprintf '<%s>' \"$@\" >&2\nexit 2\n")
    program.chmod(0o755)
    return program


@pytest.mark.parametrize(
    "fields, word",
    [
        ({"ring": None, "time": 1e-6}, "ring,time:1e-06"),
        ([("ring", 1), "time"], "ring:1,time"),
        (("ring", "time"), "ring,time"),
        ("all", "all"),
    ],
)
def test_fields_are_as_those_of_an_encoder(tmp_path, echo, fields, word):
    with pytest.raises(pcl_ext.Error, match=f"<--fields={word}>"):
        pcl_ext.encode_bag("bag", tmp_path / "x.mcap", program=echo, fields=fields)


@pytest.mark.parametrize("rate, word", [(2e6, "2000000.0bit/s"), ("2Mbit/s", "2Mbit/s"), (True, "Truebit/s")])
def test_a_rate_is_in_bits_per_second_or_has_its_unit(tmp_path, echo, rate, word):
    with pytest.raises(pcl_ext.Error, match=f"<--max-rate={word}>"):
        pcl_ext.encode_bag("bag", tmp_path / "x.mcap", program=echo, max_rate=rate)


def test_options_are_those_of_the_program(bags, tmp_path):
    bag = bags / "drive_0.mcap"
    pcl_ext.encode_bag(
        bag,
        tmp_path / "by_name.mcap",
        topics=["/front"],
        pose={"/front": (0, 0, 1, 0, 0, 90)},
        keep_points=True,
        coarsen=False,
        frames=None,
        temporal_filter=0,
    )
    words = "--topics /front --pose /front=0,0,1,0,0,90 --keep-points".split()
    command = [PROGRAM, "encode", "-q", bag, "-o", tmp_path / "by_word.mcap", *words]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    made = [(tmp_path / name).read_bytes() for name in ("by_name.mcap", "by_word.mcap")]
    assert made[0] == made[1]


def test_a_folder_of_bags_with_one_that_is_cut_off(bags, tmp_path):
    whole = (bags / "drive_3.mcap").read_bytes()
    (bags / "drive_3.mcap").write_bytes(whole[: len(whole) // 2])
    summary = pcl_ext.encode_bag(bags, tmp_path / "made", jobs=2)
    assert [bag.status for bag in summary.bags] == ["done"] * 3 + ["incomplete"]
    assert not summary.ok and len(summary.errors) >= 1
    assert "drive_3.mcap, byte" in summary.errors[0]
    assert sorted(os.listdir(tmp_path / "made")) == [
        *(f"drive_{number}.mcap" for number in range(4)),
        "manifest.jsonl",
    ]


@pytest.mark.parametrize(
    "options, code, message",
    [
        ({"resolution": -1}, "Usage", "--resolution"),
        ({"no_such_option": 3}, "Usage", "--no-such-option"),
        ({"topics": ["/left"]}, "Usage", "there are no clouds of '/left'"),
        ({"program": "/no/such/program"}, "NoProgram", "cannot run '/no/such/program'"),
    ],
)
def test_errors(bags, tmp_path, options, code, message):
    with pytest.raises(pcl_ext.Error, match=message) as caught:
        pcl_ext.encode_bag(bags / "drive_0.mcap", tmp_path / "x.mcap", **options)
    again = pickle.loads(pickle.dumps(caught.value))
    assert (again.code, str(again)) == (code, str(caught.value))
    assert not (tmp_path / "x.mcap").exists()


def test_a_program_that_is_missing_or_killed(bags, tmp_path, monkeypatch):
    call = (bags / "drive_0.mcap", tmp_path / "x.mcap")
    suicide = tmp_path / "suicide"
    suicide.write_text("#!/bin/sh\nkill -9 $$\n")
    suicide.chmod(0o755)
    with pytest.raises(pcl_ext.Error, match="killed by signal 9") as caught:
        pcl_ext.encode_bag(*call, program=suicide)
    assert caught.value.code == "Killed"
    monkeypatch.delenv("PCL_EXT_PROGRAM")
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(pcl_ext.Error, match="no program pcl_ext in PATH") as caught:
        pcl_ext.encode_bag(*call)
    assert caught.value.code == "NoProgram"


def test_progress_of_a_bag_and_of_folders(bags, tmp_path):
    calls = []

    def add(done, total):
        calls.append((done, total))

    pcl_ext.encode_bag(bags / "drive_3.mcap", tmp_path / "x.mcap", progress=add)
    assert calls[0] == (0, 12) and calls[-1] == (12, 12) and calls == sorted(calls)
    calls.clear()
    first = pcl_ext.encode_bag(bags, tmp_path / "made", progress=add)
    assert calls[0] == (0, 4) and calls[-1] == (4, 4) and calls == sorted(calls)
    assert first.skipped == () and str(first).startswith("4 bags, 36 frames, ")
    # A rerun takes what is new or changed, and says what it left out.
    calls.clear()
    (bags / "drive_1.mcap").write_bytes((bags / "drive_0.mcap").read_bytes())
    again = pcl_ext.encode_bag(bags, tmp_path / "made", progress=add)
    assert calls[0] == (0, 1) and calls[-1] == (1, 1)
    assert again.skipped == tuple(str(bags / f"drive_{number}.mcap") for number in (0, 2, 3))
    assert [bag.skipped for bag in again.bags] == [True, False, True, True]
    assert again.ok and again.frames == 34
    assert str(again).startswith("4 bags, 3 skipped, as done before, 34 frames, ")
    # Clouds of files, whose errors are not taken for progress.
    calls.clear()
    clouds = ["--streams", "/front", "-o", tmp_path / "clouds"]
    subprocess.run([PROGRAM, "decode", "-q", tmp_path / "x.mcap", *clouds], check=True)
    (tmp_path / "clouds" / "000003.pcd").write_text("no cloud")
    part = pcl_ext.encode_bag(tmp_path / "clouds", tmp_path / "y.mcap", progress=add)
    assert calls[0] == (0, 6) and calls[-1] == (6, 6)
    assert part.failures == 1 and "000003.pcd" in part.errors[0]
    with pytest.raises(pcl_ext.Error, match="^pcl_ext encode: .* exists: name another"):
        pcl_ext.encode_bag(tmp_path / "clouds", tmp_path / "y.mcap", progress=add)


def test_what_progress_raises_ends_the_program(bags, tmp_path):
    def stop(done, total):
        raise KeyError("enough")

    with pytest.raises(KeyError, match="enough"):
        pcl_ext.encode_bag(bags, tmp_path / "made", progress=stop)
    with pytest.raises(TypeError, match="progress is 5; it must be True, False"):
        pcl_ext.encode_bag(bags, tmp_path / "made", progress=5)


def test_progress_on_a_bar_of_tqdm(bags, tmp_path, capsys):
    pytest.importorskip("tqdm")
    pcl_ext.encode_bag(bags / "drive_0.mcap", tmp_path / "x.mcap", progress=True)
    assert "6/6" in capsys.readouterr().err


def load_example():
    specification = importlib.util.spec_from_file_location("encode_with_dask", EXAMPLE)
    example = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(example)
    return example


# The first that is run waits until its worker is killed. A line for each that comes to its end.
WATCHED_PROGRAM = """#!/bin/sh
if mkdir "{folder}/first" 2> /dev/null; then
  echo $PPID > "{folder}/first/written" && mv "{folder}/first/written" "{folder}/first/worker"
  while kill -0 $PPID 2> /dev/null; do sleep 0.05; done
  exit 1
fi
"{program}" "$@" && echo "$@" >> "{folder}/done"
"""


@pytest.mark.filterwarnings("ignore")  # of Dask's own
def test_dask_encodes_each_bag_once_though_a_worker_is_killed(bags, tmp_path):
    distributed = pytest.importorskip("distributed")
    example = load_example()
    watched = tmp_path / "watched"
    watched.write_text(WATCHED_PROGRAM.format(folder=tmp_path, program=PROGRAM))
    watched.chmod(0o755)
    first = tmp_path / "first" / "worker"

    def kill_first_worker():
        deadline = time.monotonic() + 60
        while not first.exists() and time.monotonic() < deadline:
            time.sleep(0.02)
        os.kill(int(first.read_text()), signal.SIGKILL)

    killer = threading.Thread(target=kill_first_worker)
    killer.start()
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address=None
    ) as cluster, distributed.Client(cluster) as client:
        workers = client.run(os.getpid).values()
        options = {"resolution": 0.05, "program": str(watched)}
        done, failed = example.encode_all(client, bags, tmp_path / "made", options, 2)
        killer.join()
        assert int(first.read_text()) not in client.run(os.getpid).values()
        again = example.encode_all(client, bags, tmp_path / "made", options, 2)
    assert int(first.read_text()) in workers
    assert failed == [] and again == ({}, [])
    names = [f"drive_{number}" for number in range(4)]
    assert {name: done[name].frames for name in sorted(done)} == dict(zip(names, (6, 8, 10, 12)))
    ended = (tmp_path / "done").read_text().splitlines()
    assert sorted(line.rpartition("/")[2] for line in ended) == [name + ".mcap" for name in names]
    assert sorted(os.listdir(tmp_path / "made")) == [name + ".mcap" for name in names]
    for name in names:
        alone = tmp_path / f"{name}.alone.mcap"
        pcl_ext.encode_bag(bags / f"{name}.mcap", alone, resolution=0.05)
        assert (tmp_path / "made" / f"{name}.mcap").read_bytes() == alone.read_bytes()


def test_the_example_takes_urls_and_tells_what_failed(bags, tmp_path):
    pytest.importorskip("distributed")
    (bags / "drive_1.mcap").write_bytes(b"no bag")
    (bags / "notes.txt").write_text("no bag either")
    command = [sys.executable, EXAMPLE, f"file://{bags}", tmp_path / "made"]
    command += ["--workers", "1", "--retries", "0", "--resolution", "0.05", "--effort=fast"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 1, done.stderr
    lines = done.stdout.splitlines()
    assert lines[0] == "3 bags encoded, 28 frames, 1 failed"
    assert lines[1:3] == ["| bag | why |", "|---|---|"] and len(lines) == 4
    assert lines[3].startswith("| drive_1 | pcl_ext encode: ")
    assert "drive_1.mcap' is not a cloud" in lines[3]


def test_bags_of_an_object_store_are_copied(bags, tmp_path):
    pytest.importorskip("distributed")
    memory = pytest.importorskip("fsspec").filesystem("memory")
    content = (bags / "drive_0.mcap").read_bytes()
    memory.pipe(
        {
            "/day/drive_0.mcap": content,
            "/day/drive_1/metadata.yaml": b"",
            "/day/drive_1/drive_1_0.mcap": content,
            "/day/readme.md": b"",
        }
    )
    example = load_example()
    urls = example.bags_of("memory://day")
    assert urls == {"drive_0": "memory:///day/drive_0.mcap", "drive_1": "memory:///day/drive_1"}
    for name, url in urls.items():
        made = tmp_path / f"{name}.mcap"
        summary = example.encode_one(url, str(made), {"resolution": 0.05})
        assert summary.frames == 6
    assert (tmp_path / "drive_0.mcap").exists()
    assert not list(tmp_path.glob(".encoding_*"))
