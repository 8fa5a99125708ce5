"""A sensor node for each sensor, and one central node.

The clouds of sensor N are /<name>_N/points; its TF frame <name>_N must be known in the
global frame. With composable:=true all nodes are in one process, whose name is that of the
argument `container`, and clouds are passed on without a copy; else each is a process.
"""
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch_ros.actions import ComposableNodeContainer, Node
from launch_ros.descriptions import ComposableNode
import yaml

ARGUMENTS = [
    ('composable', 'true', 'true: one container; false: a process for each node'),
    ('container', 'pcl_ext_container', 'name of the container'),
    ('name', 'kinect', 'of the sensors, before _N'),
    ('sensors', '[1, 2, 3, 4, 5, 6]', 'numbers of the sensors'),
    ('global_frame', 'world', 'TF frame of the world'),
    ('resolution', '0.04', 'edge of a voxel, m'),
    ('intensity', 'count', 'count, quadratic, linear, native or none'),
    ('sensor', 'kinect_v2', 'for quadratic and linear'),
    ('effort', 'fast', 'fast, balanced or small'),
    ('i_frame_rate', '30', 'frames from one I-frame to the next'),
    ('crop_box', '[0, 0, 0.1, 10, 10, 4]',
     '[x0, y0, z0, x1, y1, z1] in the world, m; []: none'),
    ('remove_outliers', 'false', 'true: noise is removed by its surroundings'),
    ('min_intensity', '', 'voxels below are removed as noise; by default 2 points, 64 of '
     '255 for linear and quadratic, 0 for native and with remove_outliers'),
    ('merge_rate', '10', 'merged clouds per second, Hz; 0: none'),
    ('map_path', '', "file for the OctoMap (.ot); '': none"),
]


def default_min_intensity(intensity, remove_outliers):
    """Voxels below are noise, in the unit of the law."""
    if remove_outliers:
        return 0.0
    return {'count': 2.0, 'quadratic': 64.0, 'linear': 64.0}.get(intensity, 0.0)


def density_unit(intensity):
    """What outliers are judged by."""
    return {'count': 'points', 'quadratic': 'faces'}.get(intensity, 'automatic')


def nodes(context):
    """The nodes for the values of the arguments."""
    values = {name: context.launch_configurations[name] for name, _, _ in ARGUMENTS}
    read = {name: yaml.safe_load(values[name])
            for name in ('composable', 'sensors', 'resolution', 'i_frame_rate',
                         'crop_box', 'remove_outliers', 'merge_rate')}
    same = {'global_frame': values['global_frame'],
            'resolution': float(read['resolution'])}
    of_sensor = dict(same, intensity=values['intensity'], sensor=values['sensor'],
                     effort=values['effort'], i_frame_rate=int(read['i_frame_rate']))
    if read['crop_box']:
        of_sensor['crop_box'] = [float(number) for number in read['crop_box']]
    min_intensity = (float(values['min_intensity']) if values['min_intensity'] else
                     default_min_intensity(values['intensity'], read['remove_outliers']))
    sensors = ['{}_{}'.format(values['name'], number) for number in read['sensors']]
    of_centre = dict(same, streams=['/{}/points/pcl_ext'.format(s) for s in sensors],
                     min_intensity=min_intensity,
                     remove_outliers=bool(read['remove_outliers']),
                     density_unit=density_unit(values['intensity']),
                     merge_rate=float(read['merge_rate']), map_path=values['map_path'])
    for sensor in sensors:
        of_centre[sensor + '.points.pcl_ext.sensor_frame'] = sensor

    def node(plugin, executable, **options):
        if read['composable']:
            return ComposableNode(package='pcl_ext_ros', plugin='pcl_ext_ros::' + plugin,
                                  name=executable,
                                  extra_arguments=[{'use_intra_process_comms': True}],
                                  **options)
        return Node(package='pcl_ext_ros', executable=executable, name=executable,
                    output='screen', **options)

    all_nodes = [node('SensorNode', 'sensor_node', namespace='/' + sensor,
                      remappings=[('input', 'points')], parameters=[of_sensor])
                 for sensor in sensors]
    all_nodes.append(node('CentralNode', 'central_node', parameters=[of_centre]))
    if not read['composable']:
        return all_nodes
    # Of several threads, so that merging and the map do not delay frames.
    return [ComposableNodeContainer(package='rclcpp_components',
                                    executable='component_container_mt',
                                    name=values['container'], namespace='',
                                    composable_node_descriptions=all_nodes,
                                    output='screen')]


def generate_launch_description():
    """The arguments and the nodes."""
    return LaunchDescription(
        [DeclareLaunchArgument(name, default_value=default, description=description)
         for name, default, description in ARGUMENTS] + [OpaqueFunction(function=nodes)])
