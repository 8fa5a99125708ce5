"""The paper's robot cell: six simulated Kinect V2 in the poses of its Table 1, a sensor node
for each, and one central node.

The arguments are these and those of six_sensors.launch.py.
"""
import os
import sys

from launch import LaunchDescription
from launch.actions import (DeclareLaunchArgument, IncludeLaunchDescription,
                            OpaqueFunction)
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch_ros.actions import LoadComposableNodes

sys.path.insert(0, os.path.dirname(__file__))
import pcl_ext_nodes  # noqa: E402

ARGUMENTS = [
    ('composable', 'true', 'true: one container; false: a process for each node'),
    *pcl_ext_nodes.PROCESSES,
    ('sensors', '[1, 2, 3, 4, 5, 6]', 'numbers of the sensors, 1 to 6'),
    ('global_frame', 'world', 'TF frame of the world'),
    ('intensity_bits', '0', 'bits of an intensity' + pcl_ext_nodes.INTENSITY_BITS),
    ('rate', '20.0', 'clouds per second of each sensor, Hz'),
    ('captured_frames', '0', '0: each cloud is captured when it is sent; else this number '
     'of frames is captured before the start and repeated, which takes less processor '
     'time'),
    ('seed', '1', 'of the simulated errors'),
]


def cell(context):
    """The simulated cell for the values of the arguments."""
    values = pcl_ext_nodes.checked(pcl_ext_nodes.values_of(context, ARGUMENTS))
    parameters = {'sensors': [int(number) for number in values['sensors']],
                  'global_frame': values['global_frame'],
                  'rate': values['rate'],
                  'captured_frames': values['captured_frames'],
                  'seed': values['seed']}
    simulated = pcl_ext_nodes.node(values, 'SimulatedCell', 'simulated_cell',
                                   parameters=[parameters])
    if not values['composable']:
        return [simulated]
    return [LoadComposableNodes(target_container=pcl_ext_nodes.absolute(
                                    values, values['container']),
                                composable_node_descriptions=[simulated])]


def generate_launch_description():
    """The arguments and the nodes."""
    six_sensors = os.path.join(os.path.dirname(__file__), 'six_sensors.launch.py')
    return LaunchDescription(
        [DeclareLaunchArgument(name, default_value=default, description=description)
         for name, default, description in ARGUMENTS] +
        [IncludeLaunchDescription(PythonLaunchDescriptionSource(six_sensors)),
         OpaqueFunction(function=cell)])
