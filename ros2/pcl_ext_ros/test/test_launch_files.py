"""Starts a launch file with the simulated cell, waits for merged clouds, and stops it.

Arguments: the folder of launch files, the name of one and its arguments. Fails if no cloud arrives, the launch does not
end well when it is interrupted, or a process stays behind. With respawn:=true the central node is killed, and clouds must
arrive again.
"""
import os
import signal
import subprocess
import sys
import time

import rclpy
from rclpy.node import Node
from sensor_msgs.msg import PointCloud2

LONGEST_WAIT = 90.0  # seconds


def processes_of_group(group):
    """The commands of the processes of a group that are not zombies."""
    listed = subprocess.run(['ps', '-e', '-o', 'pgid=,stat=,args='], check=True,
                            capture_output=True, text=True).stdout
    rows = [line.split(None, 2) for line in listed.splitlines()]
    return [row[2] for row in rows if int(row[0]) == group and row[1][0] != 'Z']


def wait_for_cloud(namespace):
    """True if a merged cloud with voxels arrives."""
    rclpy.init()
    node = Node('test_launch_files')
    widths = []
    node.create_subscription(PointCloud2, namespace + '/central_node/merged',
                             lambda cloud: widths.append(cloud.width), 10)
    deadline = time.monotonic() + LONGEST_WAIT
    while not any(widths) and time.monotonic() < deadline:
        rclpy.spin_once(node, timeout_sec=0.1)
    node.destroy_node()
    rclpy.shutdown()
    return any(widths)


def kill_central_node(group):
    """Kills the process of the central node in a group."""
    listed = subprocess.run(['ps', '-e', '-o', 'pid=,pgid=,comm='], check=True,
                            capture_output=True, text=True).stdout
    for pid, of_group, command in (line.split(None, 2) for line in listed.splitlines()):
        if int(of_group) == group and command.startswith('central_node'):
            os.kill(int(pid), signal.SIGKILL)
            return
    raise RuntimeError('there is no central_node')


def start(command):
    """A process group."""
    return subprocess.Popen(command, start_new_session=True)


def stop(process):
    """Interrupts a process group, as a terminal does; its status, and what stays behind."""
    try:
        os.killpg(process.pid, signal.SIGINT)
        return process.wait(timeout=60), processes_of_group(process.pid)
    finally:
        try:
            os.killpg(process.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass


def main():
    """Returns the exit status."""
    folder, name = sys.argv[1:3]
    started = [start(['ros2', 'launch', os.path.join(folder, name + '.launch.py')] +
                     sys.argv[3:])]
    try:
        if name == 'one_sensor':
            started.append(start(['ros2', 'run', 'pcl_ext_ros', 'simulated_cell',
                                  '--ros-args', '-p', 'sensors:=[1]', '-p', 'rate:=5.0']))
        namespaces = [argument.partition(':=')[2] for argument in sys.argv[3:]
                      if argument.startswith('namespace:=')]
        namespace = ''.join('/' + name for name in namespaces)
        has_cloud = wait_for_cloud(namespace)
        if has_cloud and 'respawn:=true' in sys.argv[3:]:
            kill_central_node(started[0].pid)
            has_cloud = wait_for_cloud(namespace)
    finally:
        ends = [stop(process) for process in started]
    print('merged cloud: {}, status and processes left: {}'.format(has_cloud, ends))
    return 0 if has_cloud and ends[0][0] == 0 and not any(left for _, left in ends) else 1


if __name__ == '__main__':
    sys.exit(main())
