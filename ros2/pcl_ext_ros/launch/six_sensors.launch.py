# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""
A sensor node for each sensor, and one central node.

The clouds of sensor N are <name>_N/points in the namespace; its TF frame <name>_N must be
known in the global frame.
"""
import os
import sys

sys.path.insert(0, os.path.dirname(__file__))
import pcl_ext_nodes  # noqa: E402

ARGUMENTS = [
    *pcl_ext_nodes.PROCESSES,
    pcl_ext_nodes.SENSOR_NODE,
    pcl_ext_nodes.CENTRAL_NODE,
    ('name', 'kinect', 'of the sensors, before _N'),
    ('sensors', '[1, 2, 3, 4, 5, 6]', 'numbers of the sensors'),
    *pcl_ext_nodes.ENCODING,
    pcl_ext_nodes.CROP_BOX_OF_CELL,
    *pcl_ext_nodes.NOISE,
    *pcl_ext_nodes.MERGING,
    *pcl_ext_nodes.MAP,
    *pcl_ext_nodes.SIMULATION,
]


def nodes(values):
    """Return the nodes for the values of the arguments."""
    of_centre = {**pcl_ext_nodes.parameters_of_centre(values),
                 **pcl_ext_nodes.parameters_of_noise(values),
                 **pcl_ext_nodes.parameters_of_map(values)}
    sensors = ['{}_{}'.format(values['name'], number) for number in values['sensors']]
    return pcl_ext_nodes.started(
        values, pcl_ext_nodes.sensors_and_centre(values, sensors, of_centre))


def generate_launch_description():
    """Return the arguments and the nodes."""
    return pcl_ext_nodes.description(ARGUMENTS, nodes)
