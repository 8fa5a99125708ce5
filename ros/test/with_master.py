#!/usr/bin/env python3
# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Starts a ROS master on loopback and runs a test with it.

Usage: with_master.py COMMAND [ARGUMENT ...]

The exit code is that of the command; 124 if it ran too long; 1 if it left a process behind,
or if the master did not start. Processes that are left are stopped. Imports no ROS packages.
"""
import ctypes
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import xmlrpc.client

SECONDS_TO_RUN = 150
SECONDS_TO_START = 30
SECONDS_TO_END = 2  # for processes that are about to end
SECONDS_TO_STOP = 10
PR_SET_CHILD_SUBREAPER = 36  # of linux/prctl.h


def wait_until(condition, seconds):
    end = time.monotonic() + seconds
    while not condition() and time.monotonic() < end:
        time.sleep(0.05)
    return condition()


def is_master(uri):
    try:
        return xmlrpc.client.ServerProxy(uri).getPid("/with_master")[0] == 1
    except (OSError, xmlrpc.client.Error):
        return False


def start_master(environment):
    """The process. Tries several times, as another process can take the free port first."""
    for _ in range(5):
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        environment["ROS_MASTER_URI"] = f"http://127.0.0.1:{port}"
        master = subprocess.Popen(["rosmaster", "--core", "-p", str(port)], env=environment,
                                  stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                  stderr=subprocess.STDOUT)
        wait_until(lambda: master.poll() is not None or is_master(environment["ROS_MASTER_URI"]),
                   SECONDS_TO_START)
        if master.poll() is None:
            return master
    sys.exit("with_master: rosmaster did not start")


def children(master):
    """The running children of this script besides the master: {pid: command}. Those whose
    parent has ended are among them, as this script adopts them."""
    found = {}
    for folder in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            state, parent = (folder / "stat").read_bytes().rpartition(b")")[2].split()[:2]
            command = (folder / "cmdline").read_bytes().replace(b"\0", b" ").decode().strip()
        except OSError:  # it ended
            continue
        if int(parent) == os.getpid() and state not in b"ZX" and int(folder.name) != master.pid:
            found[int(folder.name)] = command
    return found


def stop_children(master):
    for stop_signal in (signal.SIGTERM, signal.SIGKILL):
        def none_is_left(number=stop_signal):
            for pid in children(master):
                os.kill(pid, number)
            return not children(master)
        if wait_until(none_is_left, SECONDS_TO_STOP):
            return


def run(command, environment, master):
    """The exit code of the command."""
    test = subprocess.Popen(command, env=environment, stdin=subprocess.DEVNULL)
    try:
        code = test.wait(SECONDS_TO_RUN)
    except subprocess.TimeoutExpired:
        print(f"with_master: stopped after {SECONDS_TO_RUN} seconds", file=sys.stderr)
        return 124
    wait_until(lambda: not children(master), SECONDS_TO_END)
    left = children(master)
    for pid, name in left.items():
        print(f"with_master: left behind: {pid} {name}", file=sys.stderr)
    return 128 - code if code < 0 else code or (1 if left else 0)


def main():
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # so that what follows tidies up
    # A shell starts what runs in its background with SIGINT ignored, which nodes inherit.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)
    folder = tempfile.mkdtemp(prefix="pcl_ext_ros1_test_")
    environment = dict(os.environ, ROS_IP="127.0.0.1", ROS_HOME=folder, ROS_LOG_DIR=folder,
                       ROSCONSOLE_STDOUT_LINE_BUFFERED="1")
    environment.pop("ROS_HOSTNAME", None)
    master = None
    try:
        master = start_master(environment)
        return run(sys.argv[1:], environment, master)
    finally:
        if master:
            stop_children(master)
            master.kill()
            master.wait()
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    sys.exit(main())
