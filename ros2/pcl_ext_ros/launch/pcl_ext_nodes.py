# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""What the launch files have in common: arguments, parameters, nodes."""
import functools
import os

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch_ros.actions import Node
from launch_ros.descriptions import ComposableNode
import pcl_ext_containers
import yaml

# Arguments: name, default, description.
PROCESSES = [
    ('composable', 'true', 'true: nodes are components of containers; false: processes'),
    ('container', 'pcl_ext_container', 'name of a container'),
    ('namespace', '', 'of all nodes and of topics that do not begin with /'),
    ('respawn', 'true', 'true: what ends is started again after a second'),
]
# Of launch files with nodes of other packages.
OTHER_PROCESSES = [argument for argument in PROCESSES
                   if argument[0] in ('namespace', 'respawn')]
SENSOR_NODE = ('sensor_node', 'sensor_node', "name of a sensor's node")
CENTRAL_NODE = ('central_node', 'central_node', 'name of a central node')
ENCODING = [
    ('global_frame', 'world', "TF frame of the world; the sensors' must be known in it"),
    ('resolution', '0.04', 'edge of a voxel, m'),
    ('intensity', 'count', 'count, quadratic, linear, native or none'),
    ('intensity_bits', '0', 'bits of an intensity; larger intensities are clamped, which is '
     'logged; 0: automatic'),
    ('sensor', 'kinect_v2', 'for quadratic and linear'),
    ('effort', 'fast', 'fast, balanced or small'),
    ('i_frame_rate', '30', 'frames from one I-frame to the next'),
    ('i_frame_every', '0.0', 's from one I-frame to the next, so that one can seek in '
     'recordings; 0: i_frame_rate alone'),
]
CROP_BOX = ('crop_box', '[]', '[x0, y0, z0, x1, y1, z1] in the world, m; []: none')
CROP_BOX_OF_CELL = (CROP_BOX[0], '[0, 0, 0.1, 10, 10, 4]', CROP_BOX[2])
NOISE = [
    ('remove_outliers', 'false', 'true: noise is removed by its surroundings'),
    ('min_intensity', '', 'voxels below are removed as noise; by default 2 points, 64 of 255 '
     'for linear and quadratic, 0 for native and with remove_outliers'),
]
MERGING = [
    ('merge_rate', '10.0', 'merged clouds per second, Hz; 0: none'),
    ('merge_wait', '', "s for which merging waits for streams; by default the node's own"),
]
MAP = [
    ('map_path', '', "file for the OctoMap (.ot); '': none"),
    ('map_full_intensity', '', 'that counts as one hit; by default 4 points, 0 for native, '
     'with which each voxel does, else 255'),
]
SIMULATION = [
    ('simulated', 'false', 'true: the simulated cell is started, too'),
    ('rate', '20.0', 'clouds per second of each simulated sensor, Hz'),
    ('captured_frames', '0', '0: each simulated cloud is captured when it is sent; else this '
     'number of frames is captured before the start and repeated, which takes less '
     'processor time'),
    ('seed', '1', 'of the simulated errors'),
]

NUMBERS_WITHOUT_DEFAULT = ('min_intensity', 'map_full_intensity', 'merge_wait')
KINDS = {bool: 'true or false', int: 'a whole number', float: 'a number', list: 'a list',
         dict: 'names with what they have, {a: b}'}


def configuration(name):
    """Return the installed file with the parameters of a launch file."""
    return os.path.join(os.path.dirname(os.path.dirname(__file__)), 'config', name + '.yaml')


def yaml_of(text):
    """Return what a text is in YAML, or None."""
    try:
        return yaml.safe_load(text)
    except yaml.YAMLError:
        return None


def value_of(name, default, text):
    """Return the value of an argument, of the type of its default; an empty text as it is."""
    kind = type(yaml.safe_load(default or "''"))
    if name in NUMBERS_WITHOUT_DEFAULT:
        kind = float
    if kind is str or not text:
        return text
    try:
        value = kind(text) if kind in (int, float) else yaml_of(text)
    except ValueError:
        value = None
    if not isinstance(value, kind):
        raise RuntimeError("{} is '{}'; it must be {}".format(name, text, KINDS[kind]))
    return value


def description(arguments, actions):
    """Return a launch description of arguments, and of the actions for their values."""
    def of_context(context):
        return actions({name: value_of(name, default, context.launch_configurations[name])
                        for name, default, _ in arguments})
    return LaunchDescription(
        [DeclareLaunchArgument(name, default_value=default, description=text)
         for name, default, text in arguments] + [OpaqueFunction(function=of_context)])


def parameters_of_sensor(values):
    """Return the parameters of a sensor node."""
    parameters = {name: values[name] for name, _, _ in ENCODING}
    if values['crop_box']:
        parameters['crop_box'] = [float(number) for number in values['crop_box']]
    return parameters


def parameters_of_noise(values):
    """Return what is noise, in the unit of the law."""
    law = values['intensity']
    min_intensity = {'count': 2.0, 'quadratic': 64.0, 'linear': 64.0}.get(law, 0.0)
    if values['remove_outliers']:
        min_intensity = 0.0
    if values['min_intensity'] != '':
        min_intensity = values['min_intensity']
    return {
        'min_intensity': min_intensity,
        'remove_outliers': values['remove_outliers'],
        'density_unit': {'count': 'points', 'quadratic': 'faces'}.get(law, 'automatic'),
    }


def parameters_of_centre(values):
    """Return those of a central node, without streams, noise and map."""
    parameters = {name: values[name]
                  for name in ('global_frame', 'resolution', 'merge_rate')}
    if values['merge_wait'] != '':
        parameters['merge_wait'] = values['merge_wait']
    return parameters


def parameters_of_map(values):
    """Return those of the map, in the unit of the law."""
    full = {'count': 4.0, 'native': 0.0}.get(values['intensity'], 255.0)
    if values['map_full_intensity'] != '':
        full = values['map_full_intensity']
    return {'map_path': values['map_path'], 'map_full_intensity': full}


def absolute(values, name):
    """Return a name in the namespace of the launch file, from the root."""
    return '/'.join([''] + [part for part in (values['namespace'].strip('/'), name) if part])


def node(values, plugin, executable, name=None, namespace='', **options):
    """
    Return what makes a component, or a process.

    As with a component's remappings launch_ros can load it only once. namespace is relative to
    that of the launch file; name is by default the executable's.
    """
    options.update(name=name or executable, namespace=absolute(values, namespace))
    if values['composable']:
        return functools.partial(
            ComposableNode, package='pcl_ext_ros', plugin='pcl_ext_ros::' + plugin,
            extra_arguments=[{'use_intra_process_comms': True}], **options)
    return functools.partial(
        Node, package='pcl_ext_ros', executable=executable, output='screen',
        respawn=values['respawn'], respawn_delay=pcl_ext_containers.RESPAWN_DELAY, **options)


def other_node(values, package, executable, name, namespace='', parameters=(), **options):
    """Return a process of another package, with the file of parameters of the launch file."""
    return Node(
        package=package, executable=executable, name=name,
        namespace=absolute(values, namespace), output='screen', respawn=values['respawn'],
        respawn_delay=pcl_ext_containers.RESPAWN_DELAY,
        parameters=[values['parameters'], *parameters], **options)


def sensors_and_centre(values, sensors, of_centre, namespace=''):
    """
    Return a node for each sensor, by name, and a central node for them, in a namespace.

    of_centre are the parameters of the central node besides those of its streams.
    """
    streams = {sensor: absolute(values, '/'.join(filter(None, [namespace, sensor,
                                                               'points/pcl_ext'])))
               for sensor in sensors}
    parameters = {'streams': list(streams.values()), **of_centre}
    for sensor in sensors:
        parameters[sensor + '.points.pcl_ext.sensor_frame'] = sensor
    nodes = [node(values, 'CloudSenderNode', 'sensor_node', name=values['sensor_node'],
                  namespace='/'.join(filter(None, [namespace, sensor])),
                  remappings=[('input', 'points')],
                  parameters=[parameters_of_sensor(values)])
             for sensor in sensors]
    nodes.append(node(values, 'MergingCentreNode', 'central_node', name=values['central_node'],
                      namespace=namespace, parameters=[parameters]))
    if values['simulated']:
        nodes.append(simulated_cell(values, sensors, namespace))
    return nodes


def simulated_cell(values, sensors, namespace):
    """Return the node that sends the clouds of simulated sensors, by name."""
    numbers = {'kinect_{}'.format(number): number for number in range(1, 7)}
    for sensor in sensors:
        if sensor not in numbers:
            raise RuntimeError("the simulated cell has no sensor '{}'; it has kinect_1 to "
                               'kinect_6'.format(sensor))
    parameters = {'sensors': [numbers[sensor] for sensor in sensors]}
    for name in ('global_frame', 'rate', 'captured_frames', 'seed'):
        parameters[name] = values[name]
    return node(values, 'SimulatedCell', 'simulated_cell', namespace=namespace,
                parameters=[parameters])


def started(values, nodes, namespace=''):
    """Return the processes of nodes, or a container in the namespace with all of them."""
    if not values['composable']:
        return [make() for make in nodes]
    return pcl_ext_containers.container(
        nodes, values['container'], absolute(values, namespace), values['respawn'])
