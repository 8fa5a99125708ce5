# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Frames over a real NATS server."""

import os
import pathlib
import socket
import subprocess
import time
import traceback

import numpy as np
import pytest

import pcl_ext

# By tools/fetch_nats_server.sh.
UNPACKED = pathlib.Path(__file__).resolve().parents[2] / "build-nats-server/usr/sbin"
link = pytest.importorskip("pcl_ext.link")


@pytest.fixture
def server(tmp_path):
    """Starts servers with a configuration; returns their address."""
    servers = []

    def start(configuration=""):
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        file = tmp_path / f"{port}.conf"
        file.write_text(f'listen: "127.0.0.1:{port}"\n{configuration}\n')
        path = f"{os.environ['PATH']}:/usr/sbin:{UNPACKED}"
        with open(tmp_path / f"{port}.log", "wb") as log:
            servers.append(
                subprocess.Popen(
                    ["nats-server", "-c", file],
                    env={**os.environ, "PATH": path},
                    stderr=log,
                )
            )
        end = time.monotonic() + 60
        while time.monotonic() < end:
            try:
                socket.create_connection(("127.0.0.1", port)).close()
                break
            except ConnectionRefusedError:
                time.sleep(0.01)
        return f"nats://127.0.0.1:{port}"

    yield start
    for one in servers:
        one.kill()
        one.wait()


def frames_of(seed, count, encoder):
    random = np.random.default_rng(seed)
    return [encoder.encode(random.random((500, 3))) for _ in range(count)]


def test_frames_arrive(server):
    address = server()
    subscriber = link.FrameSubscriber(address, site="cell")
    publisher = link.FramePublisher(address, site="cell")
    name = "/näme with . and \n"
    stream = publisher.add_stream(name, {"sensor_pose": "1,2,3,0,0,0,1"})
    encoder, decoder = pcl_ext.Encoder(resolution=0.1), pcl_ext.Decoder()
    sent = frames_of(1, 5, encoder)
    for number, data in enumerate(sent):
        assert publisher.publish(stream, data, 100.5 + number)
    for number, data in enumerate(sent):
        frame = subscriber.next(20)
        assert frame == link.LinkFrame(
            name,
            100.5 + number,
            data,
            number == 0,
            {"sensor_pose": "1,2,3,0,0,0,1"} if number == 0 else {},
        )
        assert decoder.decode(frame.data) is not None
        assert f"data=<{len(data):,} bytes>, is_i_frame=" in repr(frame)
    assert subscriber.next(0) is None
    assert subscriber.statistics[name].frames == 5
    assert subscriber.statistics[name].frames_lost == 0
    assert subscriber.statistics[name].age >= 0
    assert publisher.flush()  # the server has answered
    assert publisher.statistics["frames"] == 5
    assert publisher.statistics["frames_under_way"] == 0
    assert not publisher.wants_i_frame(stream)
    subscriber.request_i_frame(name)
    end = time.monotonic() + 20
    while not publisher.wants_i_frame(stream):
        assert time.monotonic() < end
        time.sleep(0.01)
    assert not publisher.wants_i_frame(stream)  # told once


def test_replay(server, tmp_path):
    address = server(f'jetstream {{ store_dir: "{tmp_path}" }}')
    with pytest.raises(pcl_ext.Error, match="keeps no frames of the site 'cell'"):
        link.FrameSubscriber(address, site="cell", replay_from=0)


def test_what_is_wrong(server):
    address = server("authorization { user: a, password: b }")
    with pytest.raises(pcl_ext.Error, match="wrong user or password") as error:
        link.FramePublisher(address, user="a", password="c")
    assert error.value.code == "Refused"
    with pytest.raises(ValueError, match="site is 'a b'"):
        link.FrameSubscriber(address, site="a b")
    with pytest.raises(TypeError, match="site is of type int; it must be a str"):
        link.FrameSubscriber(address, site=5)
    publisher = link.FramePublisher(address, user="a", password="b")
    stream = publisher.add_stream("/a")
    with pytest.raises(ValueError, match="exists already"):
        publisher.add_stream("/a")
    with pytest.raises(TypeError, match="metadata is 5; it must be a dict of str"):
        publisher.add_stream("/b", metadata=5)
    # A cloud that max_rate left out.
    assert publisher.publish(stream, b"", 0) and publisher.statistics["frames_under_way"] == 0
    with pytest.raises(ValueError, match="not exactly one frame"):
        publisher.publish(stream, b"abc", 0)
    for wrong in (7, -1):
        with pytest.raises(ValueError, match=f"stream is {wrong}; it must be what add_stream"):
            publisher.publish(wrong, b"", 0)
        with pytest.raises(ValueError, match=f"stream is {wrong}; it must be what add_stream"):
            publisher.wants_i_frame(wrong)


@pytest.mark.parametrize(
    "name, value, error",
    [
        ("partition", -1, ValueError),
        ("partition", 2**32, ValueError),
        ("partition", "1", TypeError),
        ("max_waiting_bytes", 0, ValueError),
        ("max_waiting_bytes", 2**64, ValueError),
        ("max_waiting_bytes", 1.5, TypeError),
        ("replay_from", -1, ValueError),
        ("streams", [5], TypeError),
        ("streams", b"/a", TypeError),
        ("streams", 5, TypeError),
        ("site", "\ud800", ValueError),
        ("timeout", "2", TypeError),
        ("timeout", None, TypeError),
        ("timeout", 0, ValueError),
        ("timeout", -1, ValueError),
        ("timeout", 3601, ValueError),
        ("timeout", 1e300, ValueError),
        ("timeout", float("inf"), ValueError),
        ("timeout", float("nan"), ValueError),
        ("token", b"topsecret", TypeError),
        ("password", b"topsecret", TypeError),
        ("servers", ["nats://user:topsecret@host"], TypeError),
        ("servers", "http://user:topsecret@host", ValueError),
        ("servers", "user:topsecret@host", ValueError),
    ],
)
def test_wrong_arguments_are_named_and_passwords_are_not_shown(name, value, error):
    arguments = {"password": "topsecret", "token": "topsecret", name: value}
    of_both = name in ("timeout", "token", "password", "servers")
    for make in [link.FrameSubscriber] + of_both * [link.FramePublisher]:
        with pytest.raises(error, match=f"^{name} is ") as raised:
            make(**arguments)
        text = "".join(traceback.format_exception_only(raised.type, raised.value))
        assert "topsecret" not in text


def test_waits_are_seconds(server):
    address = server()
    subscriber = link.FrameSubscriber(address)
    publisher = link.FramePublisher(address)
    for wait in subscriber.next, publisher.flush:
        for wrong in float("inf"), float("nan"), -1, 1e10:
            with pytest.raises(ValueError, match="^timeout is .* seconds$"):
                wait(wrong)
        with pytest.raises(TypeError, match="^timeout is 'x'; it must be a number"):
            wait("x")


def test_one_stream_by_its_name(server):
    address = server()
    subscriber = link.FrameSubscriber(address, streams="/abc")
    publisher = link.FramePublisher(address)
    data = frames_of(1, 1, pcl_ext.Encoder())[0]
    for name in "a", "/abc":
        publisher.publish(publisher.add_stream(name), data, 0)
    assert subscriber.next(20).stream == "/abc"
