# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Each command of README's section on sites and of doc/site.md, in order, with a real NATS server.

Usage: test_site_documents.py PCL_EXT
"""

import os
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = pathlib.Path(sys.argv[1])
SERVER = subprocess.run(["bash", ROOT / "tools/fetch_nats_server.sh"], check=True, capture_output=True,
                        text=True).stdout.strip()
# What a machine says that has other work: the exit status is 1 then, and rightly so.
SLOW = re.compile("too slow|lost on the way|--merge-age|after a gap")
PATIENCE = 60  # seconds until something has to have come


def commands_of(document, *titles):
    """The indented lines of a document's sections, without comments."""
    text = (ROOT / document).read_text()
    for title in titles:
        section = text.split(f"\n## {title}\n", 1)[1].split("\n## ", 1)[0]
        for line in re.findall(r"^    (\S.*)$", section, re.M):
            yield re.sub(r"\s+# .*$", "", line)


def free_port():
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


class Machine:
    """A folder in place of a machine: the program is installed there, and what the documents install."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.port = free_port()
        self.server = None
        self.exports = ""
        self.programs = []  # that go on: their lines, processes and outputs
        self.probes = 0
        for name in ("bin", "share/pcl_ext", "etc", "work"):
            (self.folder / name).mkdir(parents=True)
        shutil.copy(PROGRAM, self.folder / "bin/pcl_ext")
        (self.folder / "share/pcl_ext/viewer.html").write_text('<body><script id="pcl-ext-codec"></script></body>')
        (self.folder / "share/pcl_ext/site").symlink_to(ROOT / "tools/site")
        (self.folder / "work/tools").symlink_to(ROOT / "tools")
        for name, text in {"sudo": 'exec "$@"', "apt-get": ":", "xdg-open": ":",
                           "install": 'while [[ $1 == -* ]]; do case $1 in -[ogm]) shift ;; -d) d=-d ;; esac; shift; '
                                      'done\nexec /usr/bin/install ${d:--D} "$@"'}.items():
            (self.folder / "bin" / name).write_text(f"#!/bin/bash\n{text}\n")
            (self.folder / "bin" / name).chmod(0o755)
        self.environment = {**os.environ, "PATH": f"{self.folder}/bin:{os.environ['PATH']}"}
        self.make_inputs()

    def make_inputs(self):
        """What the documents call recording.mcap, scans/ and bag.mcap."""
        for line in ("pcl_ext demo -q --sensors 1 --frames 20 --output made", "mv made/cell_sensor_1/decoded scans",
                     "pcl_ext encode -q scans -o recording.mcap -r 0.05",
                     "pcl_ext decode -q recording.mcap -o bag.mcap"):
            self.run(line)

    def placed(self, line):
        """A line with what it names of the machine in this folder."""
        line = line.replace("that-machine:4222", f"127.0.0.1:{self.port}")
        line = re.sub(r"(?<=[ =])/(etc|var/lib)/", rf"{self.folder}/\1/", line)
        line = line.replace("/usr/share/", f"{self.folder}/share/")
        return line.replace("--view", "--view --no-browser --port 0")

    def shell(self, line):
        return ["bash", "-c", f"{self.exports}set -o pipefail\n{self.placed(line)}"]

    def run(self, line):
        done = subprocess.run(self.shell(line), cwd=self.folder / "work", env=self.environment,
                              capture_output=True, text=True)
        assert done.returncode == 0, f"{line}\n{done.stdout}{done.stderr}"
        return done.stdout

    def start(self, line):
        """Starts a line that goes on until it is interrupted."""
        name = self.folder / f"output_{len(self.programs)}"
        with open(name, "w") as output:
            self.programs.append((line, subprocess.Popen(
                self.shell(re.sub(r"(?<!\S)pcl_ext (?=send|receive)", "exec pcl_ext ", line)), cwd=self.folder / "work",
                env=self.environment, stdout=output, stderr=subprocess.STDOUT), name))

    def start_server(self):
        if self.server:
            self.server.kill()
            self.server.wait()
        configuration = self.folder / "etc/nats-server.conf"
        text = configuration.read_text()
        assert "store_dir" in text
        configuration.write_text(re.sub('(store_dir: )"[^"]*"', rf'\1"{self.folder}/kept"', text))
        with open(self.folder / "server.log", "w") as log:
            self.server = subprocess.Popen(
                [SERVER, "-c", configuration, "-a", "127.0.0.1", "-p", str(self.port)],
                stdout=log, stderr=subprocess.STDOUT)
        end = time.monotonic() + PATIENCE
        while True:
            assert self.server.poll() is None and time.monotonic() < end, (self.folder / "server.log").read_text()
            try:
                return socket.create_connection(("127.0.0.1", self.port)).close()
            except ConnectionError:
                time.sleep(0.01)

    def start_centres(self, line):
        """What systemd does with pcl-ext-centre@, in place of the centres that were started by hand."""
        self.end(len(self.programs) - 1)
        unit = (ROOT / "tools/site/pcl-ext-centre@.service").read_text()
        command = re.search("ExecStart=/usr/bin/(.*)", unit)[1]
        settings = (self.folder / "etc/pcl_ext/centre.env").read_text()
        settings = re.sub(r"OPTIONS=(.*)", r"OPTIONS='\1'", settings)
        settings += f"PCL_EXT_SERVER=nats://127.0.0.1:{self.port}\n"
        (self.folder / "etc/pcl_ext/centre.env").write_text(settings)
        for part in re.findall(r"@(\w+)", line):
            self.start(f"set -a; . {self.folder}/etc/pcl_ext/centre.env; " + command.replace("%i", part))
            self.wait_for_frames(f"--site cell-merged --streams zone_{part}")

    def wait_for_frames(self, options):
        """Waits until frames come that a receiver with these options gets."""
        user = "PCL_EXT_USER=operator PCL_EXT_PASSWORD='change me as well' " if "USER" in self.exports else ""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            self.probes += 1
            probe = subprocess.run(self.shell(f"{user}pcl_ext receive -q --for 1s -o probe_{self.probes}.mcap {options}"),
                                   cwd=self.folder / "work", env=self.environment, capture_output=True, text=True)
            if probe.returncode == 0 or SLOW.search(probe.stderr):
                return
        raise AssertionError(f"nothing came: {options}\n{probe.stderr}" +
                             "".join(f"{line}\n{name.read_text()}" for line, _, name in self.programs))

    def end(self, count=None):
        """Ends what was started last, in the way of Ctrl-C, and checks what it tells."""
        count = len(self.programs) if count is None else count
        for _ in range(count):
            line, process, name = self.programs.pop()
            process.send_signal(signal.SIGINT)
            status = process.wait()
            text = name.read_text()
            if "receive" in line:
                assert status == 0 or (status == 1 and SLOW.search(text)), f"{line}: {status}\n{text}"
                assert re.search(r"^site .*: [1-9][\d,]* frames? of ", text, re.M), f"{line}\n{text}"
                if "--merge" in line:
                    assert re.search(r"; [1-9][\d,]* merged frame", text), f"{line}\n{text}"
            else:
                assert status == 130 or SLOW.search(text), f"{line}: {status}\n{text}"
                assert re.search(r"^[1-9][\d,]* frames sent to site cell", text, re.M), f"{line}\n{text}"

    def receive(self, line):
        """A centre goes on for those above it; others are ended when something has come."""
        self.start(line)
        options = re.sub(r"^.*?receive", "", line)
        site = re.search(r"--site (\S+)", options)
        merged = re.search(r"--merge (\S+)", options)
        if merged:
            above = (site[1] if site else "cell") + "-merged"
            self.wait_for_frames(f"--site {above} --streams {merged[1]}")
            return
        end = time.monotonic() + PATIENCE
        name = self.programs[-1][2]
        while "receiving from site" not in name.read_text():
            assert time.monotonic() < end, name.read_text()
            time.sleep(0.01)
        self.wait_for_frames(" ".join(re.findall(r"--streams \S+", options)))
        self.end(1)

    def replay(self, line):
        """Waits until an I-frame of each stream is kept: a replay begins there. One of all that is kept has an
        end when nothing is sent any more, also on a machine that is too slow to catch up with the sensors."""
        if "--replay all" in line:
            self.end()
        end = time.monotonic() + PATIENCE
        while True:
            done = subprocess.run(self.shell(line), cwd=self.folder / "work", env=self.environment,
                                  capture_output=True, text=True)
            if done.returncode == 0:
                assert re.search("[1-9][0-9,]* frames of", done.stdout), done.stdout
                return
            assert time.monotonic() < end, f"{line}\n{done.stdout}{done.stderr}"
            (self.folder / "work" / re.search(r"(?:-o|--map) (\S+)", line)[1]).unlink(missing_ok=True)
            time.sleep(0.5)

    def do(self, line):
        if line.startswith("mappings"):
            assert line in re.sub(r"\s+", " ", (ROOT / "tools/site/nats-server.conf").read_text())
        elif line.startswith("export"):
            self.exports += self.placed(line) + "\n"
        elif "systemctl restart nats-server" in line:
            self.end()
            self.start_server()
        elif line.startswith("$(bash tools/fetch_nats_server.sh)"):
            subprocess.run(["bash", "-c", line + " -t"], cwd=ROOT, check=True, capture_output=True)  # without a port
        elif "systemctl enable" in line:
            self.start_centres(line)
        elif "--replay" in line:
            self.replay(line)
        elif "receive" in line:
            self.receive(line)
        elif "send --cell" in line:
            self.start(line)
        else:
            self.run(line)


class Documents(unittest.TestCase):
    def run_all(self, document, *titles):
        lines = list(commands_of(document, *titles))
        self.assertGreater(len(lines), 8)
        with tempfile.TemporaryDirectory() as folder:
            machine = Machine(folder)
            try:
                for line in lines:
                    machine.do(line)
                machine.end()
            finally:
                for _, process, _ in machine.programs:
                    process.kill()
                    process.wait()
                if machine.server:
                    machine.server.kill()
                    machine.server.wait()

    def test_readme(self):
        self.run_all("README.md", "From one sensor to a site")

    def test_site(self):
        self.run_all("doc/site.md", "Commands", "Many centres", "Replay", "Security, ports")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
