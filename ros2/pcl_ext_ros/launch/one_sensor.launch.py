# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""The node of one sensor and the central node, or one of the two."""
import os
import sys

sys.path.insert(0, os.path.dirname(__file__))
import pcl_ext_nodes  # noqa: E402

ARGUMENTS = [
    *pcl_ext_nodes.PROCESSES,
    pcl_ext_nodes.SENSOR_NODE,
    pcl_ext_nodes.CENTRAL_NODE,
    ('points', '/camera/depth/points', 'topic of the clouds (sensor_msgs/PointCloud2)'),
    *pcl_ext_nodes.ENCODING,
    ('format', 'version1', 'version1 or published'),
    pcl_ext_nodes.CROP_BOX,
    *pcl_ext_nodes.NOISE,
    *pcl_ext_nodes.MERGING,
    *pcl_ext_nodes.MAP,
    ('sensor_side', 'true', 'false: that node runs on another computer'),
    ('central_side', 'true', 'false: that node runs on another computer'),
]


def nodes(values):
    """Return the nodes for the values of the arguments."""
    of_sensor = {**pcl_ext_nodes.parameters_of_sensor(values), 'format': values['format']}
    of_centre = {**pcl_ext_nodes.parameters_of_centre(values),
                 **pcl_ext_nodes.parameters_of_noise(values),
                 **pcl_ext_nodes.parameters_of_map(values)}
    chosen = []
    if values['sensor_side']:
        chosen.append(pcl_ext_nodes.node(
            values, 'CloudSenderNode', 'sensor_node', name=values['sensor_node'],
            remappings=[('input', values['points'])], parameters=[of_sensor]))
    if values['central_side']:
        chosen.append(pcl_ext_nodes.node(
            values, 'MergingCentreNode', 'central_node', name=values['central_node'],
            remappings=[('input', values['points'] + '/pcl_ext')],
            parameters=[of_centre]))
    return pcl_ext_nodes.started(values, chosen)


def generate_launch_description():
    """Return the arguments and the nodes."""
    return pcl_ext_nodes.description(ARGUMENTS, nodes)
