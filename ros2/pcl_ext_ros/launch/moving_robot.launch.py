# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""
The node of a sensor that moves, and a central node that maps what it sees, or one of the two.

TF has to have the pose of the clouds' frame in global_frame, by default odom, at their stamps.
"""
import os
import sys

sys.path.insert(0, os.path.dirname(__file__))
import pcl_ext_nodes  # noqa: E402

ARGUMENTS = [
    *pcl_ext_nodes.PROCESSES,
    ('points', '/camera/depth/points', 'topic of the clouds (sensor_msgs/PointCloud2)'),
    ('sensor_frame', 'camera_depth_optical_frame', 'TF frame of the clouds, from which the '
     'map takes rays'),
    ('parameters', pcl_ext_nodes.configuration('moving_robot'),
     'file with the parameters of sensor_node and central_node'),
    ('sensor_side', 'true', 'false: that node runs on another computer'),
    ('central_side', 'true', 'false: that node runs on another computer'),
]


def nodes(values):
    """Return the nodes for the values of the arguments."""
    chosen = []
    if values['sensor_side']:
        chosen.append(pcl_ext_nodes.node(
            values, 'CloudSenderNode', 'sensor_node',
            remappings=[('input', values['points'])], parameters=[values['parameters']]))
    if values['central_side']:
        chosen.append(pcl_ext_nodes.node(
            values, 'MergingCentreNode', 'central_node',
            remappings=[('input', values['points'] + '/pcl_ext')],
            parameters=[values['parameters'],
                        {'input.sensor_frame': values['sensor_frame']}]))
    return pcl_ext_nodes.started(values, chosen)


def generate_launch_description():
    """Return the arguments and the nodes."""
    return pcl_ext_nodes.description(ARGUMENTS, nodes)
