# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""
Zones, each with sensor nodes and a central node, and above them another central node.

The latter, the top, merges what those of the zones have merged.
Each computer of a site starts its own part, for which `only` has the names. The clouds of a
sensor are <zone>/<sensor>/points in the namespace; its TF frame, named as the sensor, must be
known in the global frame.
"""
import os
import sys

sys.path.insert(0, os.path.dirname(__file__))
import pcl_ext_nodes  # noqa: E402

TOP = 'top'
# s that the top waits longer than the zones, which publish late while they wait themselves.
LONGER_WAIT = 0.3
WAIT = 0.2  # s, of a node by itself

ARGUMENTS = [
    *pcl_ext_nodes.PROCESSES,
    pcl_ext_nodes.SENSOR_NODE,
    pcl_ext_nodes.CENTRAL_NODE,
    ('zones', '{zone_1: [kinect_1, kinect_2], zone_2: [kinect_3, kinect_4], '
     'zone_3: [kinect_5, kinect_6]}', 'the names of the sensors of each zone'),
    ('only', '', "what this computer starts: a zone, top, or a list of them; '': all"),
    *pcl_ext_nodes.ENCODING,
    pcl_ext_nodes.CROP_BOX_OF_CELL,
    *pcl_ext_nodes.NOISE,
    *pcl_ext_nodes.MERGING,
    *pcl_ext_nodes.MAP,
    *pcl_ext_nodes.SIMULATION,
]


def checked_zones(zones):
    """Return the zones, if each has a name of its own and a list of the names of sensors."""
    for zone, sensors in zones.items():
        names = [zone, *sensors] if isinstance(sensors, list) and sensors else []
        if not names or zone == TOP or not all(isinstance(name, str) for name in names):
            raise RuntimeError(
                "zones has '{}: {}'; it must be the name of a zone, other than {}, with a "
                'list of the names of its sensors'.format(zone, sensors, TOP))
    return zones


def chosen_parts(only, zones):
    """Return the names of zones, and of the top, that are started."""
    parts = [*zones, TOP]
    chosen = pcl_ext_nodes.yaml_of(only) if only else parts
    if isinstance(chosen, str):
        chosen = [chosen]
    if not isinstance(chosen, list) or not all(part in parts for part in chosen):
        raise RuntimeError("only is '{}'; it must be one of {}, or a list of them".format(
            only, ', '.join(parts)))
    return chosen


def nodes_of_zone(values, zone, sensors):
    """Return the nodes of a zone."""
    of_centre = {**pcl_ext_nodes.parameters_of_centre(values),
                 **pcl_ext_nodes.parameters_of_noise(values)}
    # Neither resolution nor crop box: the merged voxels are kept as they are.
    for name in ('effort', 'i_frame_rate', 'i_frame_every'):
        of_centre['{}.merged.pcl_ext.{}'.format(values['central_node'], name)] = values[name]
    return pcl_ext_nodes.sensors_and_centre(values, sensors, of_centre, namespace=zone)


def node_of_top(values, zones):
    """Return the central node above those of the zones, which have removed the noise."""
    streams = [pcl_ext_nodes.absolute(values, '{}/{}/merged/pcl_ext'.format(
                   zone, values['central_node']))
               for zone in zones]
    parameters = {'streams': streams, 'min_intensity': 0.0, 'remove_outliers': False,
                  **pcl_ext_nodes.parameters_of_centre(values),
                  **pcl_ext_nodes.parameters_of_map(values)}
    parameters['merge_wait'] = parameters.get('merge_wait', WAIT) + LONGER_WAIT
    return pcl_ext_nodes.node(values, 'MergingCentreNode', 'central_node',
                              name=values['central_node'], parameters=[parameters])


def parts(values):
    """Return what is started, for the values of the arguments."""
    zones = checked_zones(values['zones'])
    actions = []
    for part in chosen_parts(values['only'], zones):
        nodes = ([node_of_top(values, zones)] if part == TOP else
                 nodes_of_zone(values, part, zones[part]))
        actions += pcl_ext_nodes.started(values, nodes, '' if part == TOP else part)
    return actions


def generate_launch_description():
    """Return the arguments and the parts of the site."""
    return pcl_ext_nodes.description(ARGUMENTS, parts)
