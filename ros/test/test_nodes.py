# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""The nodes with a ROS master: streams, transforms, losses, health, parameters, launch files.

What does not need ROS, as the voxels of each law, is tested with the library.
"""
import signal
import time
import unittest

import rospy
from std_msgs.msg import Empty
from tf2_msgs.msg import TFMessage

from scenario import (EDGE, ERROR, FOLDER, OK, SHIFT, STALE, WARN, CompressedPointCloud2, Node,
                      PointCloud2, Process, Recorder, Scenario, is_i_frame, transform, voxels_in,
                      voxels_of, wait_for)


class Streams(Scenario):
    def test_voxels_frames_and_layout(self):
        self.start_both(i_frame_rate=5)
        for number in range(12):
            shown = self.expect_voxels(self.cloud(number), number)
            frame = self.frames.of(shown)
            self.assertEqual(is_i_frame(frame), number % 5 == 0)
            self.assertEqual(frame.format, "pcl_ext/version1")
            self.assertEqual(shown.header.frame_id, "world")
            for member in ("height", "width", "fields", "is_bigendian", "point_step", "row_step",
                           "is_dense"):
                self.assertEqual(getattr(frame, member), getattr(shown, member), member)
            for member in ("stamp", "frame_id"):
                self.assertEqual(getattr(frame.header, member), getattr(shown.header, member))
        self.assertEqual(len(self.voxels.messages), 12)

    def test_published_format(self):
        self.start_both(format="published", crop_box=[])
        self.clouds.publish(self.cloud(0))
        self.expect(lambda: self.voxels.messages, self.compressor.output)
        self.assertEqual(self.frames.of(self.cloud(0)).format, "pcl_ext/published")
        self.assertGreater(self.voxels.messages[0].width, 300)

    def test_colours(self):
        self.start_both(colour_bits=8)
        cloud = self.cloud(0, colour=0x104080)
        shown = self.expect_voxels(cloud, 0)
        # As the cloud has it, and what it does not have behind it.
        self.assertEqual([field.name for field in shown.fields][3:], ["rgb", "intensity"])
        self.assertEqual(bytes(shown.data[12:16]), bytes([0x80, 0x40, 0x10, 0]))

    def test_crop_box_and_names_that_are_remapped(self):
        self.mount()
        cropped = self.full("cropped")
        voxels = Recorder(self, self.full("shown"), PointCloud2)
        box = [0, -9, -9, 9, 9, 9]
        # The second name is derived from the first one after its remapping.
        Node(self, "intensity_compressor", self.full("compressor"),
             {"crop_box": box, "intensity": "count", "resolution": EDGE, "tf_timeout": 10},
             [f"{self.compressed}:={cropped}"])
        Node(self, "intensity_decompressor", self.full("decompressor"), {"min_intensity": 2},
             [f"input:={cropped}", f"{cropped}/voxels:={voxels.topic}"])
        self.expect(lambda: self.clouds.get_num_connections() == 1 and
                    voxels.subscriber.get_num_connections() == 1)

        def is_shown():
            self.clouds.publish(self.cloud(3))
            return wait_for(lambda: voxels.messages, 0.5)
        self.expect(is_shown)
        self.assertEqual(voxels_in(voxels.messages[0]),
                         {place: count for place, count in voxels_of(3).items()
                          if place[0] >= 0 and count >= 2})

    def test_other_global_frame(self):
        self.mount(parent="hall")
        self.start_compressor(global_frame="hall")
        self.start_decompressor(global_frame="/hall")
        cloud = self.cloud(0)
        cloud.header.frame_id = "/" + self.sensor
        self.assertEqual(self.expect_voxels(cloud, 0).header.frame_id, "hall")


class Transforms(Scenario):
    def move(self, cloud, shift):
        """Sends the transform at the stamp of a cloud."""
        self.moving.publish(TFMessage([transform(self.sensor, shift, cloud.header.stamp)]))

    def start(self, **changes):
        self.moving = self.publisher("/tf", TFMessage)
        self.start_compressor(**changes)
        self.start_decompressor()
        self.expect(lambda: self.moving.get_num_connections() >= 1)

    def test_clouds_are_dropped_until_there_is_a_transform(self):
        self.start(tf_timeout=0, queue_size=100)
        for number in range(7):
            self.clouds.publish(self.cloud(number))
        self.expect_value(self.compressor_health, "clouds without transform", 7)
        self.expect_level(self.compressor_health, ERROR)
        self.assertEqual(self.frames.messages, [])
        self.assertIn("no transform", self.compressor.output())
        self.mount()
        numbers = iter(range(7, 1000))

        def is_compressed():
            self.clouds.publish(self.cloud(next(numbers)))
            return wait_for(lambda: self.frames.messages, 0.2)
        self.expect(is_compressed)
        self.expect_clouds(1000, 1001)

    def test_cloud_waits_for_its_transform_which_is_interpolated(self):
        self.start()
        first, middle, last = (self.cloud(i, shift=SHIFT + 0.25 * i) for i in range(3))
        self.move(first, SHIFT)
        self.expect_voxels(first, 0)
        self.clouds.publish(middle)
        self.assertIsNone(self.frames.of(middle, 0.3))
        self.move(last, SHIFT + 0.5)
        self.expect(lambda: len(self.voxels.messages) == 2, self.compressor.output)
        self.assertEqual(voxels_in(self.voxels.messages[1]), voxels_of(1))

    def test_latest_transform_where_there_is_none_at_the_stamp(self):
        self.start(tf_timeout=0.5)
        self.move(self.cloud(0), SHIFT)
        self.expect_voxels(self.cloud(0), 0)
        self.expect_clouds(500)
        self.expect_value(self.compressor_health, "frames with last transform", 1)
        self.expect_level(self.compressor_health, WARN)


    def test_clouds_that_the_queue_drops_are_counted(self):
        self.start(tf_timeout=1, queue_size=1)
        health = self.compressor_health
        self.clouds.publish(self.cloud(0))
        self.expect_value(health, "clouds", 1)
        for number in range(1, 7):  # while one waits for its transform
            self.clouds.publish(self.cloud(number))
        self.expect(lambda: health.value("clouds missed") > 0)
        self.expect(lambda: health.value("clouds") + health.value("clouds missed") == 7,
                    lambda: health.entries()[-1:])
        self.expect_level(health, ERROR)  # as there is no transform


class Losses(Scenario):
    def test_a_lost_frame(self):
        """The test forwards the frames, and loses one."""
        link = self.publisher(self.full("link"), CompressedPointCloud2)
        voxels = Recorder(self, self.full("link/voxels"), PointCloud2)
        requests = Recorder(self, self.full("link/request_i_frame"), Empty)
        forwarded = self.publisher(self.compressed + "/request_i_frame", Empty)
        self.mount()
        self.start_compressor(i_frame_rate=1000000)
        decompressor = Node(self, "intensity_decompressor", self.full("decompressor"),
                            {"streams": [link.name]})
        self.expect(lambda: link.get_num_connections() == 1 and
                    forwarded.get_num_connections() == 1 and
                    decompressor.connections(voxels.topic) == 1 and
                    decompressor.connections(requests.topic) == 1)

        def expect_shown(number):
            frame = self.compress(number)
            link.publish(frame)
            shown = voxels.of(frame)
            self.assertIsNotNone(shown, decompressor.output())
            self.assertEqual(voxels_in(shown), voxels_of(number))
        for number in range(3):
            expect_shown(number)
        self.compress(3)  # lost
        link.publish(self.compress(4))
        self.expect(lambda: len(requests.messages) == 1)
        forwarded.publish(Empty())
        # The request may arrive after the next cloud.
        frames = [self.compress(number) for number in (5, 6)]
        self.assertTrue(any(map(is_i_frame, frames)))
        for frame in frames:
            link.publish(frame)
        expect_shown(7)
        self.assertEqual(len(requests.messages), 1)
        self.expect_value(self.decompressor_health, "frames received", 7)
        self.expect_value(self.decompressor_health, "I-frame requests", 1)
        self.assertEqual(self.decompressor_health.value("frames lost"), 1)
        self.expect_level(self.decompressor_health, WARN)

    def test_nodes_that_restart(self):
        self.start_both(i_frame_rate=1000000)
        self.expect_clouds(0, 1)
        self.compressor.end(signal.SIGKILL)
        self.expect(lambda: self.clouds.get_num_connections() == 0)
        self.start_compressor(i_frame_rate=1000000)
        self.expect(lambda: self.compressor.connections(self.compressed) == 2)
        self.expect_clouds(2, 3)
        self.decompressor.end(signal.SIGKILL)
        self.expect(lambda: self.compressor.connections(self.compressed) == 1)
        self.compress(4)
        self.start_decompressor()
        # The compressor may receive this cloud before it is told of the subscriber.
        self.clouds.publish(self.cloud(5))
        self.expect_clouds(6, 7)

    def test_bytes_that_are_no_frame_and_frames_of_others(self):
        self.start_both()
        sender = self.publisher(self.compressed, CompressedPointCloud2)
        self.expect(lambda: sender.get_num_connections() == 2)
        self.expect_clouds(0)
        good = self.frames.of(self.cloud(0))
        for size in (0, 1, 5000):
            sender.publish(CompressedPointCloud2(header=good.header, format=good.format,
                                                 compressed_data=b"P" * size))
        for text in ("draco", "", "zlib; pcl_ext/version1"):
            sender.publish(CompressedPointCloud2(header=good.header, format=text,
                                                 compressed_data=good.compressed_data))
        good.header.frame_id = "moon"
        sender.publish(good)
        health = self.decompressor_health
        self.expect_value(health, "frames failed", 3)
        self.expect_value(health, "frames of other frame id or format", 4)
        self.expect_level(health, ERROR)
        self.assertEqual(len(self.voxels.messages), 1)
        self.clouds.publish(self.cloud(1))  # an I-frame may have to be requested
        self.clouds.publish(self.cloud(2))
        self.expect_clouds(3, 4)

    def test_broken_clouds_are_refused(self):
        self.start_both()
        for number in (0, 2):
            broken = self.cloud(number)
            if number == 0:
                broken.data = broken.data[:len(broken.data) // 2]
            else:
                broken.width = broken.height = 2 ** 31
            self.clouds.publish(broken)
            self.expect_clouds(number + 1)
        self.expect_value(self.compressor_health, "clouds refused", 2)
        self.assertEqual(self.compressor_health.value("frames"), 2)
        self.expect_level(self.compressor_health, ERROR)

    def test_recorded_frames_give_the_voxels_again(self):
        self.start_both(i_frame_rate=8)
        bag = f"{FOLDER}/frames.bag"
        recording = Process(self, ["rosbag", "record", "--limit=20", "-O", bag,
                                   self.compressed])
        self.expect(lambda: self.compressor.connections(self.compressed) == 3, recording.output)
        self.expect_clouds(*range(20))
        self.assertEqual(recording.process.wait(20), 0, recording.output())
        again = Recorder(self, self.full("again/voxels"), PointCloud2)
        fresh = Node(self, "intensity_decompressor", self.full("fresh"),
                     {"streams": [self.full("again")]})
        self.expect(lambda: fresh.connections(again.topic) == 1)
        player = Process(self, ["rosbag", "play", "--quiet", "--wait-for-subscribers", bag,
                                f"{self.compressed}:={self.full('again')}"])
        self.expect(lambda: len(again.messages) == 20,
                    lambda: f"{len(again.messages)} clouds\n{player.output()}")
        for number, shown in enumerate(again.messages):
            self.assertEqual(shown.header.stamp, self.cloud(number).header.stamp)
            self.assertEqual(voxels_in(shown), voxels_of(number))


class Diagnostics(Scenario):
    def test_a_stream_that_does_not_come(self):
        self.mount()
        self.start_compressor()
        self.start_decompressor(streams=[self.compressed, self.full("silent")])
        self.expect_clouds(0)
        silent = self.decompressor_health
        silent.prefix = self.full("decompressor")[1:] + ": " + self.full("silent")
        self.expect_level(silent, STALE)
        silent.prefix = self.full("decompressor")[1:] + ": all streams"
        self.expect_value(silent, "streams", 2)
        self.expect_value(silent, "streams in sync", 1)

    def test_levels_and_figures(self):
        """Ranges of times are wide, as they depend on the computer."""
        self.start_both()
        for health in (self.compressor_health, self.decompressor_health):
            self.expect_level(health, STALE)
        for number in range(30):
            cloud = self.cloud(number % 4)
            cloud.header.stamp = rospy.Time.now()
            self.expect_voxels(cloud, number % 4)
            time.sleep(0.08)
        for health in (self.compressor_health, self.decompressor_health):
            self.assertEqual(health.entries()[-1].level, OK, health.entries()[-1])
            for key, lowest, highest in [("frames per second", 1, 13),
                                         ("bytes per second", 100, 100000),
                                         ("mean cycle time, ms", 0.001, 500),
                                         ("mean latency, ms", 0.1, 2000),
                                         ("compression ratio", 3, 1000),
                                         ("voxels", 400, 440)]:
                self.assertTrue(lowest <= health.value(key) <= highest, health.entries()[-1])
        self.assertEqual(self.compressor_health.value("points not finite"), 7)
        before = len(self.compressor_health.entries())
        start = time.monotonic()
        for health in (self.compressor_health, self.decompressor_health):
            self.expect_level(health, ERROR)  # as no clouds come
        reports = len(self.compressor_health.entries()) - before
        self.assertTrue(1 <= reports <= time.monotonic() - start + 2)


WRONG = {
    "intensity_compressor": [
        ({"resolution": 0.0}, "~resolution is 0; it must be"),
        ({"reslution": 0.04}, "Unknown parameter ~reslution; known are: "),
        ({"i_frame_rate": 2.5}, "~i_frame_rate is 2.5; it must be"),
        ({"effort": "slow"}, "~effort is 'slow'; it must be"),
        ({"effort": 2}, "~effort is 2; it must be"),
        ({"intensity": "quadratic"}, "Parameter ~sensor is not set; it must be set, by name or"),
        ({"crop_box": [0, 0, 0, 1, 1, "far"]},
         "~crop_box is [0, 0, 0, 1, 1, 'far']; it must be a list of 6 finite numbers, or []"),
        ({"remove_outliers": 1}, "~remove_outliers is 1; it must be true or false"),
        ({"tf_timeout": -0.1}, "~tf_timeout is -0.1; it must be")],
    "intensity_decompressor": [
        ({"streams": "/a"}, "~streams is '/a'; it must be a list of topics"),
        ({"streams": []}, "~streams is []; it must be a list of topics"),
        ({"streams": ["/a", 5]}, "~streams is ['/a', 5]; it must be a list of topics"),
        ({"streams": ["/a", "/a"]}, "~streams has /a twice"),
        ({"streams": ["no name"]}, "no name"),
        ({"min_log_odd": 1}, "Unknown parameter ~min_log_odd; known are: "),
        ({"density_unit": "dots"}, "~density_unit is 'dots'; it must be one of: automatic,"),
        ({"max_waiting_frames": 0}, "~max_waiting_frames is 0; it must be"),
        ({"global_frame": ""}, "~global_frame is ''; it must be")]}


class Parameters(Scenario):
    def test_wrong_ones_end_a_node_with_one_line(self):
        for program, cases in WRONG.items():
            nodes = [(Node(self, program, self.full(f"{program}_{i}"), parameters), message)
                     for i, (parameters, message) in enumerate(cases)]
            nodes += [(Node(self, program, self.full(program + "_line"), {}, ["_threads:=many"]),
                       "~threads is 'many'; it must be a whole number"),
                      (Node(self, program, self.full(program + "_name"), {}, ["input:=no name"]),
                       "no name")]
            for node, message in nodes:
                with self.subTest(message):
                    self.assertEqual(node.process.wait(20), 1, node.output())
                    self.assertIn(message, node.output())
                    self.assertEqual(node.output().count("\n"), 1, node.output())

    def test_right_ones_are_accepted(self):
        self.mount()
        self.start_compressor(effort="small", colour_bits=4, keep_points=False, threads=2,
                              remove_outliers=False, min_log_odds=1, queue_size=7)
        self.start_decompressor(min_intensity=3, remove_outliers=False, min_log_odds=1,
                                density_unit="voxels", threads=2, max_waiting_frames=3)
        cloud = self.cloud(0)
        self.clouds.publish(cloud)
        self.assertEqual(voxels_in(self.voxels.of(cloud)),
                         {place: count for place, count in voxels_of(0).items() if count >= 3})


class LaunchFiles(Scenario):
    def test_one_sensor(self):
        """On one computer, and each side on its own."""
        self.mount()
        arguments = ["roslaunch", "--skip-log-check", "pcl_ext_ros1", "one_sensor.launch",
                     f"points:={self.input}", f"resolution:={EDGE}", "min_intensity:=0",
                     "crop_box:=[-9, -9, -9, 9, 9, 9]"]
        for number, sides in enumerate([[[]], [["central_side:=false"], ["sensor_side:=false"]]]):
            launched = [Process(self, arguments + side) for side in sides]
            cloud = self.cloud(number)

            def shown(sent=cloud):
                self.clouds.publish(sent)
                return self.voxels.of(sent, 0.5)
            self.expect(shown, launched[0].output)
            self.assertEqual(voxels_in(self.voxels.of(cloud)), voxels_of(number))
            for process in launched:
                self.assertEqual(process.end(), 0, process.output())
                self.assertNotIn("escalating", process.output())
            self.expect(lambda: self.clouds.get_num_connections() == 0)

    def test_required_node_that_ends_ends_all(self):
        launched = Process(self, ["roslaunch", "--skip-log-check", "pcl_ext_ros1",
                                  "one_sensor.launch", f"points:={self.input}", "effort:=slow",
                                  "required:=true"])
        self.expect(lambda: launched.process.poll() is not None, launched.output)
        self.assertIn("~effort is 'slow'", launched.output())


if __name__ == "__main__":
    unittest.main(warnings="ignore")  # rosgraph leaves sockets to the garbage collector
