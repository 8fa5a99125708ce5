# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Nav2's costmap, by itself, with what a central node publishes."""
import os
import sys

sys.path.insert(0, os.path.dirname(__file__))
import pcl_ext_nodes  # noqa: E402

ARGUMENTS = [
    *pcl_ext_nodes.OTHER_PROCESSES,
    ('parameters', pcl_ext_nodes.configuration('costmap'),
     'file with the parameters of costmap and costmap_manager'),
]


def nodes(values):
    """Return the nodes for the values of the arguments."""
    return [
        pcl_ext_nodes.other_node(values, 'nav2_costmap_2d', 'nav2_costmap_2d', 'costmap'),
        pcl_ext_nodes.other_node(values, 'nav2_lifecycle_manager', 'lifecycle_manager',
                                 'costmap_manager')]


def generate_launch_description():
    """Return the arguments and the nodes."""
    return pcl_ext_nodes.description(ARGUMENTS, nodes)
