# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""
Starts an installed launch file, waits until all streams are merged, and stops it.

Fails if streams are missing, a node is in another namespace, what was killed does not come back,
the launch does not end well when it is interrupted, or a process stays behind. The simulated
cell is started beside those that lack one: with moving_robot it drives through the frame odom,
and the voxels have to follow. The obstacles of costmap have to be those that are merged, and the
nodes of costmap and octomap_server must know each parameter of their files; where the package of
one of these is not installed the status is 77.
"""
import argparse
import os
import re
import signal
import subprocess
import sys
import time

from ament_index_python.packages import get_package_share_directory, PackageNotFoundError
from composition_interfaces.srv import ListNodes
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
import domain_coordinator
from geometry_msgs.msg import TransformStamped
import numpy
from rcl_interfaces.srv import ListParameters
import rclpy
from rclpy.time import Time
from sensor_msgs.msg import PointCloud2
from tf2_msgs.msg import TFMessage
import yaml

LONGEST_WAIT = 90.0  # s
# In which no stream is missing. Longer than max_merge_age, in which an old frame is merged.
COMPLETE_FOR = 3.0  # s
# Of others, by the launch file that needs them.
PACKAGES = {'costmap': ['nav2_costmap_2d', 'nav2_lifecycle_manager'],
            'octomap_server': ['octomap_server']}
SKIPPED = 77
SIMULATED_CELL = ['ros2', 'run', 'pcl_ext_ros', 'simulated_cell', '--ros-args', '-p',
                  'sensors:=[1]', '-p', 'rate:=5.0']
CELL_WITH_FLOOR = ['ros2', 'launch', 'pcl_ext_ros', 'simulated_cell.launch.py',
                   'sensors:=[1, 2]', 'captured_frames:=1', 'rate:=5', 'merge_rate:=2',
                   'crop_box:=[0, 0, -0.1, 10, 10, 4]']
STREAM_IN_SENSOR_FRAME = ['ros2', 'launch', 'pcl_ext_ros', 'one_sensor.launch.py',
                          'points:=/kinect_1/points', 'global_frame:=kinect_1',
                          'central_side:=false']
# What is started beside a launch file, by its name.
BESIDE = {'one_sensor': [SIMULATED_CELL],
          'moving_robot': [SIMULATED_CELL + ['-p', 'global_frame:=base']],
          'costmap': [CELL_WITH_FLOOR],
          'octomap_server': [SIMULATED_CELL, STREAM_IN_SENSOR_FRAME]}


class Centre:
    """What a central node merges."""

    def __init__(self, node, name, streams):
        self.node = node
        self.streams = streams
        self.voxels = 0
        self.complete_since = None
        node.create_subscription(PointCloud2, name + '/merged', self.take_cloud, 10)
        node.create_subscription(DiagnosticArray, name + '/merged/streams',
                                 self.take_streams, 10)

    def take_cloud(self, cloud):
        self.voxels = cloud.width

    def take_streams(self, array):
        streams = [entry for entry in array.status if not entry.name.endswith('all streams')]
        missing = [entry.name for entry in streams if entry.level == DiagnosticStatus.STALE]
        if missing or len(streams) < self.streams:
            self.complete_since = None
        elif self.complete_since is None:
            self.complete_since = time.monotonic()

    def wait_until_complete(self):
        """Wait until clouds with voxels of all streams arrive, for some seconds."""
        self.voxels = 0
        self.complete_since = None
        wait_for(self.node, 'all streams', lambda: self.voxels and self.complete_since and
                 time.monotonic() > self.complete_since + COMPLETE_FOR)


class Robot:
    """What carries the simulated cell along x, and where the voxels are from it."""

    SPEED = 0.25  # m/s

    def __init__(self, node, voxels):
        self.node = node
        self.start = node.get_clock().now()
        self.positions = []  # m, of the clouds
        self.distances = []  # m, from there to the median of their voxels
        self.transforms = node.create_publisher(TFMessage, '/tf', 10)
        node.create_timer(0.02, self.drive)
        node.create_subscription(PointCloud2, voxels, self.compare, 10)

    def position(self, time):
        return self.SPEED * (time - self.start).nanoseconds * 1e-9

    def drive(self):
        now = self.node.get_clock().now()
        pose = TransformStamped(child_frame_id='base')
        pose.header.stamp = now.to_msg()
        pose.header.frame_id = 'odom'
        pose.transform.translation.x = self.position(now)
        self.transforms.publish(TFMessage(transforms=[pose]))

    def compare(self, cloud):
        points = numpy.frombuffer(cloud.data, numpy.float32).reshape(cloud.width, -1)
        self.positions.append(self.position(Time.from_msg(cloud.header.stamp)))
        self.distances.append(numpy.median(points[:, 0]) - self.positions[-1])

    def check(self):
        """Fail unless the voxels follow over two metres, while TF may be late at times."""
        wait_for(self.node, 'clouds along the way', lambda: numpy.ptp(self.positions or [0]) > 2)
        if numpy.ptp(self.distances) > 0.3:
            raise RuntimeError('distances of voxels: {}'.format(self.distances))


class Costmap:
    """The obstacles of the costmap, and those that are merged; both are sets of cells."""

    # m, a cube in the air, through which both sensors see the floor.
    PHANTOM = numpy.mgrid[5.5:5.8:0.04, 1.4:1.7:0.04, 1.0:1.3:0.04].reshape(3, -1).T

    def __init__(self, node):
        from nav_msgs.msg import OccupancyGrid  # Nav2's, whose packages may be missing
        self.node = node
        self.obstacles = set()
        self.merged = set()
        self.edge = None
        self.clouds = node.create_publisher(PointCloud2, '/central_node/merged', 1)
        self.cloud = None
        node.create_subscription(OccupancyGrid, '/costmap', self.take_grid, 1)
        node.create_subscription(PointCloud2, '/central_node/merged', self.take_cloud, 10)

    def take_grid(self, grid):
        self.edge = round(grid.info.resolution, 6)  # Nav2 has it as a double
        costs = numpy.array(grid.data).reshape(grid.info.height, grid.info.width)
        rows, columns = numpy.nonzero(costs == 100)
        self.obstacles = set(zip(columns.tolist(), rows.tolist()))

    def cells(self, points):
        return set(map(tuple, numpy.floor(points[:, :2] / self.edge).astype(int).tolist()))

    def take_cloud(self, cloud):
        self.cloud = cloud
        if self.edge is None:
            return
        points = numpy.frombuffer(cloud.data, numpy.float32).reshape(cloud.width, -1)
        self.merged = self.cells(points[(points[:, 2] > 0.1) & (points[:, 2] < 2.0)])

    def is_right(self):
        """Return whether nearly all obstacles are merged voxels, and the other way round."""
        return len(self.merged) > 500 and \
            len(self.merged ^ self.obstacles) < 0.05 * len(self.merged)

    def show_phantom(self):
        """Publish what was there for a moment; return whether it is an obstacle."""
        self.cloud.width = len(self.PHANTOM)
        points = numpy.zeros((len(self.PHANTOM), self.cloud.point_step // 4), numpy.float32)
        points[:, :3] = self.PHANTOM
        self.cloud.row_step = points.nbytes
        self.cloud.data = points.tobytes()
        self.clouds.publish(self.cloud)
        return self.cells(self.PHANTOM) <= self.obstacles

    def check(self):
        """Fail unless obstacles are where voxels are, and go when these do."""
        wait_for(self.node, 'obstacles where voxels are', self.is_right)
        if self.cells(self.PHANTOM) & self.obstacles:
            raise RuntimeError('the place of the phantom is not free')
        wait_for(self.node, 'the phantom', self.show_phantom)
        wait_for(self.node, 'its end', lambda: not self.cells(self.PHANTOM) & self.obstacles)


def check_parameters(node, file):
    """Fail unless the nodes have each parameter of the file in config."""
    path = os.path.join(get_package_share_directory('pcl_ext_ros'), 'config', file + '.yaml')
    with open(path, encoding='utf-8') as text:
        expected = {name.split('/')[-1]: set(names_of(values['ros__parameters']))
                    for name, values in yaml.safe_load(text).items()}

    def nodes():
        return {name: space for name, space in node.get_node_names_and_namespaces()
                if name in expected}
    wait_for(node, 'the nodes ' + ' '.join(expected), lambda: len(nodes()) == len(expected))
    for name, space in nodes().items():
        client = node.create_client(
            ListParameters, '{}/{}/list_parameters'.format(space.rstrip('/'), name))
        wait_for(node, 'the parameters of ' + name, client.service_is_ready)

        def are_known():
            answer = client.call_async(ListParameters.Request())
            rclpy.spin_until_future_complete(node, answer, timeout_sec=5.0)
            return answer.done() and expected[name] <= set(answer.result().result.names)
        wait_for(node, 'all parameters of ' + name, are_known)


def names_of(parameters, prefix=''):
    """Return the names of parameters, with dots between."""
    for name, value in parameters.items():
        if isinstance(value, dict):
            yield from names_of(value, prefix + name + '.')
        else:
            yield prefix + name


def wait_for_map(node):
    """Wait for the centres of occupied nodes, in the frame of the map."""
    maps = []
    node.create_subscription(PointCloud2, '/octomap_point_cloud_centers', maps.append, 1)
    wait_for(node, 'a map', lambda: maps and maps[-1].width > 1000)
    if maps[-1].header.frame_id != 'world':
        raise RuntimeError('the map is in ' + maps[-1].header.frame_id)


def wait_for(node, what, condition):
    """Wait until a condition holds, while messages arrive."""
    deadline = time.monotonic() + LONGEST_WAIT
    while not condition():
        if time.monotonic() > deadline:
            raise RuntimeError('waited in vain for {}'.format(what))
        rclpy.spin_once(node, timeout_sec=0.1)


def processes_of_group(group):
    """Return the commands of the processes of a group that are not zombies, by number."""
    listed = subprocess.run(['ps', '-ww', '-e', '-o', 'pid=,pgid=,stat=,args='], check=True,
                            capture_output=True, text=True).stdout
    rows = [line.split(None, 3) for line in listed.splitlines()]
    return {int(row[0]): row[3] for row in rows if int(row[1]) == group and row[2][0] != 'Z'}


def processes_with(group, text):
    """Return the processes of a group whose commands have a text."""
    return {number: command for number, command in processes_of_group(group).items()
            if re.search(text, command)}


def components(node, command):
    """Return the components in the container with a command; none if it does not answer."""
    name = '{}/{}/_container/list_nodes'.format(
        re.search(r'__ns:=(\S*)', command)[1].rstrip('/'),
        re.search(r'__node:=(\S*)', command)[1])
    client = node.create_client(ListNodes, name)
    try:
        if not client.wait_for_service(1.0):
            return []
        answer = client.call_async(ListNodes.Request())
        rclpy.spin_until_future_complete(node, answer, timeout_sec=5.0)
        return sorted(answer.result().full_node_names) if answer.done() else []
    finally:
        node.destroy_client(client)


def kill_and_wait(node, group, text):
    """Kill the process of a group whose command has a text, and wait for its successor."""
    (number, command), = processes_with(group, text).items()
    is_container = 'component_container' in command
    before = components(node, command) if is_container else []
    print('killed: {} with {}'.format(command, before), flush=True)
    os.kill(number, signal.SIGKILL)

    def is_back():
        successors = [new for other, new in processes_with(group, text).items()
                      if other != number]
        return successors and (not is_container or components(node, successors[0]) == before)

    wait_for(node, 'its successor', is_back)


def check_namespace(node, namespace):
    """Fail if there is a node outside of a namespace, but those of launch and of this test."""
    outside = [space + '/' + name for name, space in node.get_node_names_and_namespaces()
               if not (space + '/').startswith(namespace + '/') and
               name != node.get_name() and 'launch_ros' not in name]
    if outside:
        raise RuntimeError('outside of {}: {}'.format(namespace, outside))


def start(command):
    """Start a process group."""
    return subprocess.Popen(command, start_new_session=True)


def stop(process):
    """Interrupt a process group, as a terminal does; return its status and what stays."""
    try:
        os.killpg(process.pid, signal.SIGINT)
        return process.wait(timeout=60), processes_of_group(process.pid)
    finally:
        try:
            os.killpg(process.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass


def run(options):
    """Return whether the launch file does what the options say."""
    started = [start(['ros2', 'launch', 'pcl_ext_ros', options.file + '.launch.py',
                      *options.arguments])]
    fault = None
    try:
        started += [start(command) for command in BESIDE.get(options.file, [])]
        rclpy.init(args=[])
        node = rclpy.create_node('test_launch_files')
        is_moving = options.file == 'moving_robot'
        if is_moving:
            robot = Robot(node, options.centre + '/kinect_1/points/pcl_ext/voxels')
        if options.file in PACKAGES:
            check_parameters(node, options.file)
        if options.file == 'octomap_server':
            wait_for_map(node)
        else:
            centre = Centre(node, options.centre, options.streams)
            centre.wait_until_complete()
        if options.file == 'costmap':
            Costmap(node).check()
        check_namespace(node, options.namespace)
        if is_moving:
            robot.check()
        if options.kill:
            kill_and_wait(node, started[0].pid, options.kill)
            centre.wait_until_complete()
        node.destroy_node()
        rclpy.shutdown()
    except RuntimeError as failure:
        fault = failure
    finally:
        ends = [stop(process) for process in started]
    print('fault: {}; status and processes left: {}'.format(fault, ends))
    return not fault and ends[0][0] == 0 and not any(left for _, left in ends)


def main():
    """Return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--centre', default='/central_node', help='whose clouds arrive')
    parser.add_argument('--streams', type=int, default=1, help='of the centre, at least')
    parser.add_argument('--namespace', default='', help='of all nodes')
    parser.add_argument('--kill', help='text in the command of a process that is killed')
    parser.add_argument('file')
    parser.add_argument('arguments', nargs='*')
    options = parser.parse_args()
    try:
        for package in PACKAGES.get(options.file, []):
            get_package_share_directory(package)
    except PackageNotFoundError as missing:
        print('skipped: {}'.format(missing))
        return SKIPPED
    os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    # Tests that run at the same time have domains of their own.
    with domain_coordinator.domain_id() as domain:
        os.environ['ROS_DOMAIN_ID'] = str(domain)
        return 0 if run(options) else 1


if __name__ == '__main__':
    sys.exit(main())
