"""Starts a launch file with the simulated cell, waits for merged clouds, and stops it.

Arguments: the launch file and its arguments. Fails if no cloud arrives, the launch does not
end well when it is interrupted, or a process stays behind.
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


def wait_for_cloud():
    """True if a merged cloud with voxels arrives."""
    rclpy.init()
    node = Node('test_launch_files')
    widths = []
    node.create_subscription(PointCloud2, '/central_node/merged',
                             lambda cloud: widths.append(cloud.width), 10)
    deadline = time.monotonic() + LONGEST_WAIT
    while not any(widths) and time.monotonic() < deadline:
        rclpy.spin_once(node, timeout_sec=0.1)
    node.destroy_node()
    rclpy.shutdown()
    return any(widths)


def main():
    """Returns the exit status."""
    launched = subprocess.Popen(['ros2', 'launch'] + sys.argv[1:],
                                start_new_session=True)
    try:
        has_cloud = wait_for_cloud()
        # To all, as a terminal does.
        os.killpg(launched.pid, signal.SIGINT)
        status = launched.wait(timeout=60)
        left = processes_of_group(launched.pid)
    finally:
        try:
            os.killpg(launched.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
    print('merged cloud: {}, status: {}, left: {}'.format(has_cloud, status, left))
    return 0 if has_cloud and status == 0 and not left else 1


if __name__ == '__main__':
    sys.exit(main())
