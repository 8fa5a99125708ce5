"""A sensor node for each sensor, and one central node.

The clouds of sensor N are <name>_N/points in the namespace; its TF frame <name>_N must be
known in the global frame. With composable:=true all nodes are in one process, whose name is
that of the argument `container`, and clouds are passed on without a copy; else each is a
process.
"""
import os
import sys

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction

sys.path.insert(0, os.path.dirname(__file__))
import pcl_ext_nodes  # noqa: E402

ARGUMENTS = [
    ('composable', 'true', 'true: one container; false: a process for each node'),
    *pcl_ext_nodes.PROCESSES,
    pcl_ext_nodes.CENTRAL_NODE,
    ('name', 'kinect', 'of the sensors, before _N'),
    ('sensors', '[1, 2, 3, 4, 5, 6]', 'numbers of the sensors'),
    ('global_frame', 'world', 'TF frame of the world'),
    ('resolution', '0.04', 'edge of a voxel, m'),
    ('intensity', 'count', 'count, quadratic, linear, native or none'),
    ('intensity_bits', '0', 'bits of an intensity' + pcl_ext_nodes.INTENSITY_BITS),
    ('sensor', 'kinect_v2', 'for quadratic and linear'),
    ('effort', 'fast', 'fast, balanced or small'),
    ('i_frame_rate', '30', 'frames from one I-frame to the next'),
    ('crop_box', '[0, 0, 0.1, 10, 10, 4]',
     '[x0, y0, z0, x1, y1, z1] in the world, m; []: none'),
    ('remove_outliers', 'false', 'true: noise is removed by its surroundings'),
    pcl_ext_nodes.NOISE,
    ('merge_rate', '10.0', 'merged clouds per second, Hz; 0: none'),
    ('map_path', '', "file for the OctoMap (.ot); '': none"),
]


def nodes(context):
    """The nodes for the values of the arguments."""
    values = pcl_ext_nodes.checked(pcl_ext_nodes.values_of(context, ARGUMENTS))
    of_sensor = pcl_ext_nodes.parameters_of_sensor(
        values, ('global_frame', 'intensity', 'sensor', 'effort'))
    sensors = ['{}_{}'.format(values['name'], number) for number in values['sensors']]
    of_centre = {'streams': [pcl_ext_nodes.absolute(values, sensor + '/points/pcl_ext')
                             for sensor in sensors],
                 'global_frame': values['global_frame'],
                 'resolution': values['resolution'],
                 'merge_rate': values['merge_rate'],
                 'map_path': values['map_path'],
                 'map_full_intensity': pcl_ext_nodes.full_intensity_of(values),
                 **pcl_ext_nodes.parameters_of_noise(values)}
    for sensor in sensors:
        of_centre[sensor + '.points.pcl_ext.sensor_frame'] = sensor
    all_nodes = [pcl_ext_nodes.node(values, 'SensorNode', 'sensor_node', namespace=sensor,
                                    remappings=[('input', 'points')],
                                    parameters=[of_sensor])
                 for sensor in sensors]
    all_nodes.append(pcl_ext_nodes.node(values, 'CentralNode', 'central_node',
                                        name=values['central_node'],
                                        parameters=[of_centre]))
    return pcl_ext_nodes.started(values, all_nodes)


def generate_launch_description():
    """The arguments and the nodes."""
    return LaunchDescription(
        [DeclareLaunchArgument(name, default_value=default, description=description)
         for name, default, description in ARGUMENTS] + [OpaqueFunction(function=nodes)])
