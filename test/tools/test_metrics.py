# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Metrics of pcl_ext view as Prometheus' own parser reads them; the documents name those that exist.

Usage: test_metrics.py PCL_EXT WRITE_HEALTH_METRICS
"""

import contextlib
import json
import pathlib
import re
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import urllib.request

from prometheus_client.parser import text_string_to_metric_families

DOCUMENTS = pathlib.Path(__file__).resolve().parents[2] / "doc"
PROGRAM, WRITER = sys.argv[1:3]
NAMES = [b"/sensor_1", b'quote " back \\ brace } comma , end \\', b"two\nlines\r\ttab", b"\xc3\xa9\xe2\x80\xa8",
         b"# HELP x\n# TYPE x counter\nx 1", b" {le=\"1\"} ", b"bytes \xff\xfe", b""]


def families_of(text):
    families = list(text_string_to_metric_families(text))
    names = [family.name for family in families]
    assert len(set(names)) == len(names), "families come twice"
    return {family.name: family for family in families}


def written():
    return families_of(subprocess.run([WRITER, *NAMES], check=True, capture_output=True).stdout.decode())


class View:
    """pcl_ext view --cell with one viewer, who takes what comes."""

    without_proxy = urllib.request.build_opener(urllib.request.ProxyHandler({}))

    def __enter__(self):
        self.folder = tempfile.TemporaryDirectory()
        page = pathlib.Path(self.folder.name) / "page.html"
        page.write_text('<body><script id="pcl-ext-codec"></script></body>')
        self.program = subprocess.Popen(
            [PROGRAM, "view", "--cell", "--sensors", "2", "--no-browser", "--port", "0", "--page", page],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        line = self.program.stdout.readline()
        self.port = int(re.search(r"http://127\.0\.0\.1:(\d+)/", line)[1])
        self.viewer = socket.create_connection(("127.0.0.1", self.port))
        self.viewer.sendall(b"GET /api/live HTTP/1.1\r\nHost: localhost\r\nConnection: Upgrade\r\n"
                            b"Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
                            b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n")
        self.reader = threading.Thread(target=self.read)
        self.reader.start()
        return self

    def read(self):
        with contextlib.suppress(ConnectionError):
            while self.viewer.recv(1 << 16):
                pass

    def __exit__(self, *_):
        self.program.send_signal(signal.SIGINT)
        self.program.communicate()
        self.reader.join()
        self.viewer.close()
        self.folder.cleanup()

    def metrics(self):
        with self.without_proxy.open(f"http://127.0.0.1:{self.port}/metrics") as answer:
            assert answer.headers["Content-Type"] == "text/plain; version=0.0.4; charset=utf-8"
            return families_of(answer.read().decode())

    def metrics_after(self, frames):
        """As soon as each sensor has made so many frames."""
        end = time.monotonic() + 60
        while time.monotonic() < end:
            families = self.metrics()
            if all(sample.value >= frames for sample in families["pcl_ext_sender_frames"].samples):
                return families
            time.sleep(0.02)
        raise AssertionError("no frames")


class Metrics(unittest.TestCase):
    def check_histogram(self, family):
        self.assertEqual(family.type, "histogram")
        streams = {}
        for sample in family.samples:
            streams.setdefault(sample.labels["stream"], {}).setdefault(sample.name, []).append(sample)
        for samples in streams.values():
            buckets = samples[family.name + "_bucket"]
            bounds = [float(sample.labels["le"]) for sample in buckets]
            counts = [sample.value for sample in buckets]
            self.assertEqual(bounds, sorted(set(bounds)))
            self.assertEqual(bounds[-1], float("inf"))
            self.assertEqual(counts, sorted(counts))
            self.assertEqual([counts[-1]], [sample.value for sample in samples[family.name + "_count"]])
            self.assertGreaterEqual(samples[family.name + "_sum"][0].value, 0)
        return streams

    def test_of_the_cell(self):
        with View() as view:
            first = view.metrics_after(2)
            second = view.metrics_after(4)
        self.assertEqual(set(first), set(second))
        for name, family in second.items():
            self.assertRegex(name, "^pcl_ext_(sender|view)_")
            if family.type == "counter":
                before = {tuple(sample.labels.items()): sample.value for sample in first[name].samples}
                for sample in family.samples:
                    self.assertTrue(sample.name.endswith("_total"))
                    self.assertGreaterEqual(sample.value, before[tuple(sample.labels.items())])
        frames = {sample.labels["stream"]: sample.value for sample in second["pcl_ext_sender_frames"].samples}
        self.assertEqual(list(frames), ["/cell_sensor_1", "/cell_sensor_2"])
        streams = self.check_histogram(second["pcl_ext_sender_encode_seconds"])
        for name, samples in streams.items():
            self.assertEqual(samples["pcl_ext_sender_encode_seconds_count"][0].value, frames[name])
            self.assertGreater(samples["pcl_ext_sender_encode_seconds_sum"][0].value, 0)
        for sample in second["pcl_ext_sender_frame_bytes"].samples:
            self.assertGreater(sample.value, 100 * frames[sample.labels["stream"]])
        self.assertEqual([sample.value for sample in second["pcl_ext_view_viewers"].samples], [1])
        self.assertGreater(second["pcl_ext_view_frames_sent"].samples[0].value, 0)

    def test_names_come_back(self):
        names = [name.decode() if name != b"bytes \xff\xfe" else r"bytes \xff\xfe" for name in NAMES]
        families = written()
        for name in "pcl_ext_stream_frames_decoded", "pcl_ext_sender_clouds", "pcl_ext_link_frames":
            samples = families[name].samples
            self.assertEqual([sample.labels["stream"] for sample in samples], names)
            self.assertEqual([sample.labels["site"] for sample in samples], ['a "b"\n\\'] * len(names))
            self.assertEqual([sample.value for sample in samples], list(range(1, len(names) + 1)))
        for name in "pcl_ext_stream_decode_seconds", "pcl_ext_sender_encode_seconds":
            self.assertEqual(list(self.check_histogram(families[name])), names)


class Documents(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        with View() as view:
            cls.families = {**written(), **view.metrics()}

    def test_table_has_each_metric(self):
        rows = [f"| `{family.name}{'_total' if family.type == 'counter' else ''}` | {family.type} | "
                f"{family.documentation} |" for family in self.families.values()]
        lines = (DOCUMENTS / "monitoring.md").read_text().splitlines()
        table = [line for line in lines if line.startswith("| `pcl_ext_")]
        self.assertEqual(sorted(table), sorted(rows))

    def test_numbers_of_series(self):
        def series(kind):
            return sum(sample.labels.get("stream") == "/sensor_1" for name, family in written().items()
                       if name.startswith(f"pcl_ext_{kind}_") for sample in family.samples)

        sentence = (f"Each stream has {series('stream')} series where it is decoded, {series('link')} where it is "
                    f"received from a site, each sensor {series('sender')}: ")
        self.assertTrue(sentence in (DOCUMENTS / "monitoring.md").read_text(), sentence)

    def test_dashboard_names_metrics_that_exist(self):
        dashboard = json.loads((DOCUMENTS / "grafana_dashboard.json").read_text())
        expressions = [target["expr"] for panel in dashboard["panels"] for target in panel["targets"]]
        exist = {sample.name for family in self.families.values() for sample in family.samples}
        for expression in expressions:
            named = set(re.findall(r"pcl_ext_\w+", expression))
            self.assertTrue(named)
            self.assertLessEqual(named, exist)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
