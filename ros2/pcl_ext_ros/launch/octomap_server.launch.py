# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""
octomap_server with decoded streams, each in the frame of its sensor.

octomap_server takes rays from the origin of a cloud's frame. For streams in the global frame,
such as those of a central node, that is no sensor.
"""
import os
import sys

sys.path.insert(0, os.path.dirname(__file__))
import pcl_ext_nodes  # noqa: E402

ARGUMENTS = [
    *pcl_ext_nodes.OTHER_PROCESSES,
    ('points', '[/camera/depth/points]', 'topics of the clouds that are sent as '
     '<topic>/pcl_ext: by the plugin, or by a sensor_node whose global_frame is that of its '
     'sensor'),
    ('parameters', pcl_ext_nodes.configuration('octomap_server'),
     'file with the parameters of octomap_server and of the decoders'),
]


def nodes(values):
    """Return the nodes for the values of the arguments."""
    clouds = pcl_ext_nodes.absolute(values, 'octomap_server/clouds')
    mapping = pcl_ext_nodes.other_node(
        values, 'octomap_server', 'octomap_server_node', 'octomap_server',
        remappings=[('cloud_in', clouds)])
    decoders = [
        pcl_ext_nodes.other_node(
            values, 'point_cloud_transport', 'republish', 'decoder',
            namespace='octomap_server/' + points.strip('/'),
            parameters=[{'in_transport': 'pcl_ext', 'out_transport': 'raw'}],
            remappings=[('in/pcl_ext', points + '/pcl_ext'), ('out', clouds)])
        for points in (points if points.startswith('/') else
                       pcl_ext_nodes.absolute(values, points)
                       for points in values['points'])]
    return [mapping, *decoders]


def generate_launch_description():
    """Return the arguments and the nodes."""
    return pcl_ext_nodes.description(ARGUMENTS, nodes)
