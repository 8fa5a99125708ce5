"""The node of one sensor and the central node, or one of the two.

With composable:=true both are in one process; else each is a process.
"""
import os
import sys

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction

sys.path.insert(0, os.path.dirname(__file__))
import pcl_ext_nodes  # noqa: E402

ARGUMENTS = [
    ('composable', 'false', 'true: one container; false: a process for each node'),
    *pcl_ext_nodes.PROCESSES,
    ('sensor_node', 'sensor_node', "name of the sensor's node"),
    pcl_ext_nodes.CENTRAL_NODE,
    ('points', '/camera/depth/points', 'topic of the clouds (sensor_msgs/PointCloud2)'),
    ('global_frame', 'world', "TF frame of the world; the sensor's must be known in it"),
    ('resolution', '0.04', 'edge of a voxel, m'),
    ('intensity', 'count', 'count, quadratic, linear, native or none'),
    ('intensity_bits', '0', 'bits of an intensity' + pcl_ext_nodes.INTENSITY_BITS),
    ('sensor', 'kinect_v2', 'for quadratic and linear'),
    ('effort', 'balanced', 'fast, balanced or small'),
    ('format', 'version1', 'version1 or published'),
    ('i_frame_rate', '30', 'frames from one I-frame to the next'),
    ('crop_box', '[]', '[x0, y0, z0, x1, y1, z1] in the world, m; []: none'),
    ('remove_outliers', 'false', 'true: the central node removes noise by its '
     'surroundings'),
    pcl_ext_nodes.NOISE,
    ('map_path', '', "file for the OctoMap (.ot); '': none"),
    ('map_full_intensity', '', 'that counts as one hit; by default 4 points, else 255'),
    ('sensor_side', 'true', 'false: that node runs on another computer'),
    ('central_side', 'true', 'false: that node runs on another computer'),
]


def nodes(context):
    """The nodes for the values of the arguments."""
    values = pcl_ext_nodes.checked(pcl_ext_nodes.values_of(context, ARGUMENTS))
    of_sensor = pcl_ext_nodes.parameters_of_sensor(
        values, ('global_frame', 'intensity', 'sensor', 'effort', 'format'))
    of_centre = {'global_frame': values['global_frame'],
                 'resolution': values['resolution'],
                 'map_path': values['map_path'],
                 'map_full_intensity': values['map_full_intensity'] or
                 pcl_ext_nodes.full_intensity_of(values),
                 **pcl_ext_nodes.parameters_of_noise(values)}
    chosen = []
    if values['sensor_side']:
        chosen.append(pcl_ext_nodes.node(
            values, 'SensorNode', 'sensor_node', name=values['sensor_node'],
            remappings=[('input', values['points'])], parameters=[of_sensor]))
    if values['central_side']:
        chosen.append(pcl_ext_nodes.node(
            values, 'CentralNode', 'central_node', name=values['central_node'],
            remappings=[('input', values['points'] + '/pcl_ext')],
            parameters=[of_centre]))
    return pcl_ext_nodes.started(values, chosen)


def generate_launch_description():
    """The arguments and the nodes."""
    return LaunchDescription(
        [DeclareLaunchArgument(name, default_value=default, description=description)
         for name, default, description in ARGUMENTS] + [OpaqueFunction(function=nodes)])
