#!/usr/bin/env python3
"""Starts a ROS master on loopback and runs a test with it.

Usage: with_master.py [--time-limit SECONDS] COMMAND [ARGUMENT ...]

The exit code is that of the command; 124 if it ran too long; 1 if it left a process behind,
or if the master did not start. Processes that are left are stopped. Runs with any Python 3,
as it imports no ROS packages.
"""
import argparse
import ctypes
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import xmlrpc.client

SECONDS_TO_START = 30
SECONDS_TO_STOP = 10
SECONDS_TO_END = 2  # for processes that are about to end
PR_SET_PDEATHSIG = 1  # of linux/prctl.h
PR_SET_CHILD_SUBREAPER = 36


def die_with_parent():
    """Called in a child: the kernel kills it if this script is killed."""
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)


def adopt_orphans():
    """Processes whose parent ended become children of this script instead of init's."""
    if ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0) != 0:
        sys.exit("with_master: prctl failed")


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def master_answers(uri):
    try:
        return xmlrpc.client.ServerProxy(uri).getPid("/with_master")[0] == 1
    except (OSError, xmlrpc.client.Error):
        return False


def start_master(environment, folder):
    """Returns the process and its URI. Tries several times, as another process can take
    the free port first."""
    for _ in range(5):
        port = free_port()
        uri = f"http://127.0.0.1:{port}"
        with open(os.path.join(folder, "master.txt"), "wb") as output:
            master = subprocess.Popen(
                ["rosmaster", "--core", "-p", str(port)],
                env=dict(environment, ROS_MASTER_URI=uri), stdin=subprocess.DEVNULL,
                stdout=output, stderr=output, start_new_session=True,
                preexec_fn=die_with_parent)
        end = time.monotonic() + SECONDS_TO_START
        while master.poll() is None and time.monotonic() < end:
            if master_answers(uri):
                return master, uri
            time.sleep(0.02)
        stop_master(master)
    sys.exit("with_master: rosmaster did not start")


def stop_master(master):
    if master.poll() is None:
        master.send_signal(signal.SIGINT)
    try:
        master.wait(SECONDS_TO_STOP)
    except subprocess.TimeoutExpired:
        master.kill()
        master.wait()


def process_ids():
    return set(map(int, filter(str.isdigit, os.listdir("/proc"))))


def processes():
    """{pid: (state, parent)} of all processes, at a time when none began or ended."""
    while True:
        found = {}
        try:
            for pid in process_ids():
                with open(f"/proc/{pid}/stat", "rb") as file:
                    state, parent = file.read().rpartition(b")")[2].split()[:2]
                found[pid] = (state, int(parent))
        except OSError:
            continue
        if process_ids() == set(found):
            return found


def descendants(master):
    """The processes that the test started, in all sessions: {pid: command}. They are below
    this script, as it adopts processes without a parent. The master is not among them."""
    all_processes = processes()

    def is_of_test(pid):
        while pid in all_processes and pid != master.pid:
            pid = all_processes[pid][1]
            if pid == os.getpid():
                return True
        return False

    found = {}
    for pid, (state, _) in all_processes.items():
        if state not in (b"Z", b"X") and is_of_test(pid):
            try:
                with open(f"/proc/{pid}/cmdline", "rb") as file:
                    found[pid] = file.read().replace(b"\0", b" ").decode().strip()
            except OSError:  # it ended
                continue
    return found


def wait_until_none(master, seconds):
    end = time.monotonic() + seconds
    while descendants(master) and time.monotonic() < end:
        time.sleep(0.05)
    return descendants(master)


def stop_all(master):
    for stop_signal in (signal.SIGINT, signal.SIGKILL):
        for pid in descendants(master):
            try:
                os.kill(pid, stop_signal)
            except ProcessLookupError:
                pass
        if not wait_until_none(master, SECONDS_TO_STOP):
            return


def run(command, environment, time_limit, master):
    """Returns the exit code of the command, 124 if it ran too long."""
    test = subprocess.Popen(command, env=environment, stdin=subprocess.DEVNULL,
                            start_new_session=True, preexec_fn=die_with_parent)
    try:
        code = test.wait(time_limit)
    except subprocess.TimeoutExpired:
        print(f"with_master: stopped after {time_limit} seconds", file=sys.stderr)
        stop_all(master)
        test.wait()
        return 124
    if code < 0:
        print(f"with_master: ended by signal {-code}", file=sys.stderr)
        return 128 - code
    return code


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--time-limit", type=float, default=100.0, help="seconds")
    parser.add_argument("command", nargs=argparse.REMAINDER)
    arguments = parser.parse_args()
    if not arguments.command:
        parser.error("no command")

    # SystemExit, so that the finally below runs.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    adopt_orphans()
    folder = tempfile.mkdtemp(prefix="pcl_ext_ros1_test_")
    environment = dict(os.environ, ROS_IP="127.0.0.1", ROS_HOME=folder,
                       ROS_LOG_DIR=os.path.join(folder, "log"),
                       ROSCONSOLE_STDOUT_LINE_BUFFERED="1")
    environment.pop("ROS_HOSTNAME", None)
    os.mkdir(environment["ROS_LOG_DIR"])
    master = None
    try:
        master, uri = start_master(environment, folder)
        environment.update({"ROS_MASTER_URI": uri})
        code = run(arguments.command, environment, arguments.time_limit, master)
        left = wait_until_none(master, SECONDS_TO_END)
        for pid, name in left.items():
            print(f"with_master: left behind: {pid} {name}", file=sys.stderr)
        return code or (1 if left else 0)
    finally:
        if master:
            stop_all(master)
            stop_master(master)
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    sys.exit(main())
