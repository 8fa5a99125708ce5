# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""A sensor, its compressor and the decompressor: what the tests of the nodes share.

The clouds are made of voxels, so that the voxels that have to arrive are known without the
library: each point is well within its voxel, wherever the sensor is.
"""
import os
import pathlib
import signal
import subprocess
import time
import unittest
import xmlrpc.client

import numpy as np
import rosgraph
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TransformStamped
from pcl_ext_ros1.msg import CompressedPointCloud2
from sensor_msgs.msg import PointCloud2, PointField
from tf2_msgs.msg import TFMessage

NODES = os.environ["PCL_EXT_ROS1_NODES"]
FOLDER = os.environ["ROS_HOME"]  # of with_master.py
EDGE = 0.125  # of a voxel, metres
OK, WARN, ERROR, STALE = range(4)  # levels of diagnostics


def wait_for(condition, seconds=20.0):
    """Long, as a node can take seconds to start. Only a test that fails waits so long."""
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            return bool(condition())
        time.sleep(0.005)
    return True


class Process:
    """A program with its output in a file. It ends at the end of the test at the latest."""

    def __init__(self, test, command):
        self.path = pathlib.Path(FOLDER) / f"output_{time.monotonic_ns()}.txt"
        with open(self.path, "wb") as output:
            self.process = subprocess.Popen(command, stdout=output, stderr=output,
                                            stdin=subprocess.DEVNULL)
        test.addCleanup(self.end)

    def end(self, number=signal.SIGINT):
        """Its exit code."""
        self.process.send_signal(number)
        try:
            return self.process.wait(20)
        except subprocess.TimeoutExpired:
            self.process.kill()
            return self.process.wait()

    def output(self):
        return self.path.read_text()


class Node(Process):
    def __init__(self, test, program, name, parameters, remappings=()):
        self.name = name  # with its namespace
        for parameter, value in parameters.items():
            rospy.set_param(f"{name}/{parameter}", value)
        space, _, base = name.rpartition("/")
        super().__init__(test, [f"{NODES}/{program}", f"__ns:={space}", f"__name:={base}",
                                *remappings])

    def connections(self, topic):
        """Over how many connections it publishes. Asks the node: the master does not know."""
        try:
            uri = rosgraph.Master("/tests").lookupNode(self.name)
            info = xmlrpc.client.ServerProxy(uri).getBusInfo("/tests")[2]
        except (OSError, rosgraph.MasterException):
            return 0
        return sum(1 for entry in info if entry[2] == "o" and entry[4] == topic)


class Recorder:
    """All messages of a topic."""

    def __init__(self, test, topic, kind):
        self.topic = topic
        self.messages = []
        self.subscriber = rospy.Subscriber(topic, kind, self.messages.append, queue_size=1000)
        test.addCleanup(self.subscriber.unregister)

    def of(self, cloud, seconds=20.0):
        """The message with the stamp of a cloud; None if it does not come."""
        def found():
            return [m for m in list(self.messages) if m.header.stamp == cloud.header.stamp]
        return found()[0] if wait_for(found, seconds) else None


class Health(Recorder):
    """The entry of /diagnostics about the first topic of a node."""

    def __init__(self, test, node):
        super().__init__(test, "/diagnostics", DiagnosticArray)
        self.prefix = node[1:] + ": /"

    def entries(self):
        return [entry for message in list(self.messages) for entry in message.status
                if entry.name.startswith(self.prefix)]

    def value(self, key):
        for entry in self.entries()[-1:]:
            for pair in entry.values:
                if pair.key == key:
                    return float(pair.value)
        return None


# A rotation about an oblique axis, as a quaternion x, y, z, w, and a shift, metres.
ROTATION = np.array([0.1, -0.5, 0.3, 0.8]) / np.linalg.norm([0.1, -0.5, 0.3, 0.8])
SHIFT = np.array([0.513, -0.277, 1.391])


def rotation_matrix():
    vector, w = ROTATION[:3], ROTATION[3]
    cross = np.cross(np.eye(3), vector)
    return np.eye(3) + 2 * w * cross + 2 * cross @ cross


def transform(frame, shift=SHIFT, stamp=None, parent="world"):
    """Where the sensor is."""
    message = TransformStamped()
    message.header.frame_id = parent
    message.header.stamp = stamp or rospy.Time.now()
    message.child_frame_id = frame
    for name, value in zip("xyz", shift):
        setattr(message.transform.translation, name, value)
    for name, value in zip("xyzw", ROTATION):
        setattr(message.transform.rotation, name, value)
    return message


def voxels_of(number):
    """The voxels of a cloud, {(i, j, k): number of points}: most are those of other clouds."""
    same, own = np.random.default_rng(1), np.random.default_rng(1000 + number)
    places = np.concatenate([same.integers(-12, 12, (400, 3)), own.integers(-12, 12, (40, 3))])
    counts = np.concatenate([same.integers(1, 5, 400), own.integers(1, 5, 40)])
    return {tuple(place): int(count) for place, count in zip(places.tolist(), counts)}


def cloud_of(number, frame, shift=SHIFT, colour=None):
    """A cloud of these voxels, seen from the sensor, with some points that are not finite."""
    voxels = voxels_of(number)
    random = np.random.default_rng(number)
    centres = (np.array(list(voxels)) + 0.5) * EDGE
    points = np.repeat(centres, list(voxels.values()), axis=0)
    points += random.uniform(-0.4, 0.4, points.shape) * EDGE
    points = (points - shift) @ rotation_matrix()
    points = np.concatenate([points, np.full((7, 3), np.nan)]).astype("<f4")
    names = ["x", "y", "z"]
    if colour is not None:
        names.append("rgb")
        column = np.full((len(points), 1), colour, "<u4").view("<f4")
        points = np.hstack([points, column])
    message = PointCloud2(height=1, width=len(points), point_step=4 * len(names),
                          row_step=points.nbytes, data=points.tobytes())
    message.fields = [PointField(name, 4 * i, PointField.FLOAT32, 1)
                      for i, name in enumerate(names)]
    message.header.frame_id = frame
    # In the future, as nodes do not wait for transforms at old stamps. No float and no
    # microseconds can represent it.
    message.header.stamp = rospy.Time(4000000000 + number, 123456789)
    return message


def voxels_in(message):
    """The voxels of a published cloud, {(i, j, k): intensity}."""
    names = {field.name: field.offset // 4 for field in message.fields}
    assert set(names) in ({"x", "y", "z", "intensity"}, {"x", "y", "z", "intensity", "rgb"}), names
    assert len(message.data) == message.row_step == message.width * message.point_step
    columns = [names[name] for name in ("x", "y", "z", "intensity")]
    points = np.frombuffer(message.data, "<f4").reshape(-1, message.point_step // 4)[:, columns]
    places = np.round(points[:, :3] / EDGE - 0.5)
    assert np.abs((places + 0.5) * EDGE - points[:, :3]).max(initial=0) < 1e-5
    return dict(zip(map(tuple, places.astype(int).tolist()), points[:, 3].tolist()))


class Scenario(unittest.TestCase):
    """Nodes and topics are in a namespace with the name of the test, as the master keeps
    what earlier tests have set."""

    static = TFMessage()

    @classmethod
    def setUpClass(cls):
        if not rospy.core.is_initialized():
            rospy.init_node("tests", anonymous=True, disable_signals=True)
        # One latched message, which has the transforms of all tests.
        cls.static_transforms = rospy.Publisher("/tf_static", TFMessage, latch=True, queue_size=1)

    def setUp(self):
        self.space = "/" + self._testMethodName
        self.sensor = "sensor_of_" + self._testMethodName
        self.input = self.full("input")
        self.compressed = self.input + "/pcl_ext"
        self.clouds = self.publisher(self.input, PointCloud2)
        self.frames = Recorder(self, self.compressed, CompressedPointCloud2)
        self.voxels = Recorder(self, self.compressed + "/voxels", PointCloud2)
        self.compressor_health = Health(self, self.full("compressor"))
        self.decompressor_health = Health(self, self.full("decompressor"))

    def full(self, name):
        return f"{self.space}/{name}"

    def publisher(self, topic, kind):
        publisher = rospy.Publisher(topic, kind, queue_size=1000)
        self.addCleanup(publisher.unregister)
        return publisher

    def expect(self, condition, what=""):
        """Waits until it holds. What is printed if it does not: a text, or what gives one."""
        if not wait_for(condition):
            self.fail(what() if callable(what) else what)

    def mount(self, **changes):
        """Tells TF where the sensor is."""
        self.static.transforms.append(transform(self.sensor, **changes))
        self.static_transforms.publish(self.static)

    def start_compressor(self, **changes):
        """Starts it, with a fixed grid, and waits until it is connected."""
        parameters = {"crop_box": [-9, -9.0, -9, 9, 9, 9], "intensity": "count",
                      "resolution": EDGE, "tf_timeout": 10, **changes}
        self.compressor = Node(self, "intensity_compressor", self.full("compressor"), parameters)
        self.expect(lambda: self.clouds.get_num_connections() == 1 and
                    self.compressor.connections(self.compressed) >= 1, self.compressor.output)

    def start_decompressor(self, **parameters):
        """Starts it and waits until it is connected, also with the compressor."""
        self.decompressor = Node(self, "intensity_decompressor", self.full("decompressor"),
                                 {"streams": [self.compressed], **parameters})
        self.expect(lambda: self.decompressor.connections(self.voxels.topic) == 1 and
                    self.compressor.connections(self.compressed) == 2, self.decompressor.output)

    def start_both(self, **changes):
        self.mount()
        self.start_compressor(**changes)
        self.start_decompressor()

    def cloud(self, number, **changes):
        return cloud_of(number, self.sensor, **changes)

    def compress(self, number):
        """The frame of a cloud."""
        cloud = self.cloud(number)
        self.clouds.publish(cloud)
        frame = self.frames.of(cloud)
        self.assertIsNotNone(frame, self.compressor.output())
        return frame

    def expect_voxels(self, cloud, number):
        """Publishes a cloud; expects the voxels of its number, and the cloud's stamp."""
        self.clouds.publish(cloud)
        shown = self.voxels.of(cloud)
        self.assertIsNotNone(shown, self.compressor.output() + self.decompressor.output())
        self.assertEqual(voxels_in(shown), voxels_of(number))
        return shown

    def expect_clouds(self, *numbers):
        for number in numbers:
            self.expect_voxels(self.cloud(number), number)

    def expect_value(self, health, key, value):
        self.expect(lambda: health.value(key) == value, lambda: f"{key}: {health.entries()[-1:]}")

    def expect_level(self, health, level):
        self.expect(lambda: any(entry.level == level for entry in health.entries()),
                    lambda: f"no level {level}: {health.entries()[-1:]}")


def is_i_frame(message):
    """As doc/bitstream.md has it: the flags are behind magic, version and checksum."""
    return message.compressed_data[9] & 1 == 1
