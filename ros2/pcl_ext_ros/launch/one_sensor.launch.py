"""The node of one sensor and the central node, or one of the two.

With composable:=true both are in one process; else each is a process.
"""
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch_ros.actions import ComposableNodeContainer, Node
from launch_ros.descriptions import ComposableNode
import yaml

ARGUMENTS = [
    ('composable', 'false', 'true: one container; false: a process for each node'),
    ('points', '/camera/depth/points', 'topic of the clouds (sensor_msgs/PointCloud2)'),
    ('global_frame', 'world', "TF frame of the world; the sensor's must be known in it"),
    ('resolution', '0.04', 'edge of a voxel, m'),
    ('intensity', 'count', 'count, quadratic, linear, native or none'),
    ('sensor', 'kinect_v2', 'for quadratic and linear'),
    ('effort', 'balanced', 'fast, balanced or small'),
    ('format', 'version1', 'version1 or published'),
    ('i_frame_rate', '30', 'frames from one I-frame to the next'),
    ('crop_box', '[]', '[x0, y0, z0, x1, y1, z1] in the world, m; []: none'),
    ('remove_outliers', 'false', 'true: the central node removes noise by its '
     'surroundings'),
    ('min_intensity', '', 'voxels below are removed as noise; by default 2 points, 64 of '
     '255 for linear and quadratic, 0 for native and with remove_outliers'),
    ('map_path', '', "file for the OctoMap (.ot); '': none"),
    ('map_full_intensity', '', 'that counts as one hit; by default 4 points, else 255'),
    ('sensor_side', 'true', 'false: that node runs on another computer'),
    ('central_side', 'true', 'false: that node runs on another computer'),
]


def default_min_intensity(intensity, remove_outliers):
    """Voxels below are noise, in the unit of the law."""
    if remove_outliers:
        return 0.0
    return {'count': 2.0, 'quadratic': 64.0, 'linear': 64.0}.get(intensity, 0.0)


def density_unit(intensity):
    """What outliers are judged by."""
    return {'count': 'points', 'quadratic': 'faces'}.get(intensity, 'automatic')


def parameters_of_sensor(values):
    """Those of the sensor's node."""
    parameters = {name: values[name]
                  for name in ('global_frame', 'intensity', 'sensor', 'effort', 'format')}
    parameters['resolution'] = float(values['resolution'])
    parameters['i_frame_rate'] = int(values['i_frame_rate'])
    crop_box = yaml.safe_load(values['crop_box'])
    if crop_box:
        parameters['crop_box'] = [float(number) for number in crop_box]
    return parameters


def parameters_of_centre(values):
    """Those of the central node."""
    intensity = values['intensity']
    remove_outliers = bool(yaml.safe_load(values['remove_outliers']))
    full = 4.0 if intensity == 'count' else 255.0
    return {
        'global_frame': values['global_frame'],
        'resolution': float(values['resolution']),
        'remove_outliers': remove_outliers,
        'min_intensity': (float(values['min_intensity']) if values['min_intensity'] else
                          default_min_intensity(intensity, remove_outliers)),
        'density_unit': density_unit(intensity),
        'map_path': values['map_path'],
        'map_full_intensity': float(values['map_full_intensity'] or full),
    }


def nodes(context):
    """The nodes for the values of the arguments."""
    values = {name: context.launch_configurations[name] for name, _, _ in ARGUMENTS}
    composable = yaml.safe_load(values['composable'])

    def node(plugin, executable, source, parameters):
        options = {'package': 'pcl_ext_ros', 'name': executable,
                   'remappings': [('input', source)], 'parameters': [parameters]}
        if composable:
            return ComposableNode(plugin='pcl_ext_ros::' + plugin,
                                  extra_arguments=[{'use_intra_process_comms': True}],
                                  **options)
        return Node(executable=executable, output='screen', **options)

    chosen = []
    if yaml.safe_load(values['sensor_side']):
        chosen.append(node('SensorNode', 'sensor_node', values['points'],
                           parameters_of_sensor(values)))
    if yaml.safe_load(values['central_side']):
        chosen.append(node('CentralNode', 'central_node', values['points'] + '/pcl_ext',
                           parameters_of_centre(values)))
    if not composable:
        return chosen
    # Of several threads, so that merging and the map do not delay frames.
    return [ComposableNodeContainer(package='rclcpp_components',
                                    executable='component_container_mt',
                                    name='pcl_ext_container', namespace='',
                                    composable_node_descriptions=chosen,
                                    output='screen')]


def generate_launch_description():
    """The arguments and the nodes."""
    return LaunchDescription(
        [DeclareLaunchArgument(name, default_value=default, description=description)
         for name, default, description in ARGUMENTS] + [OpaqueFunction(function=nodes)])
