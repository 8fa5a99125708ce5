"""What the launch files have in common."""
from launch_ros.actions import ComposableNodeContainer, Node
from launch_ros.descriptions import ComposableNode
import yaml

NOISE = ('min_intensity', '', 'voxels below are removed as noise; by default 2 points, 64 '
         'of 255 for linear and quadratic, 0 for native and with remove_outliers')


CENTRAL_NODE = ('central_node', 'central_node', 'name of the central node')
PROCESSES = [
    ('container', 'pcl_ext_container', 'name of the container'),
    ('namespace', '', 'of all nodes and of topics that do not begin with /'),
    ('respawn', 'false', 'true: a process that ends is started again; with '
     'composable:=false only'),
]
INTENSITY_BITS = '; larger intensities are clamped, which is logged; 0: automatic'

NUMBERS_WITHOUT_DEFAULT = ('min_intensity', 'map_full_intensity')
KINDS = {bool: 'true or false', int: 'a whole number', float: 'a number', list: 'a list'}


def value_of(name, default, text):
    """The value of an argument, of the type of its default. An empty text stays one."""
    kind = type(yaml.safe_load(default or "''"))
    if name in NUMBERS_WITHOUT_DEFAULT:
        kind = float
    if kind is str or not text:
        return text
    try:
        value = kind(text) if kind in (int, float) else yaml.safe_load(text)
    except (ValueError, yaml.YAMLError):
        value = None
    if not isinstance(value, kind):
        raise RuntimeError("{} is '{}'; it must be {}".format(name, text, KINDS[kind]))
    return value


def values_of(context, arguments):
    """The values of a launch file's arguments."""
    return {name: value_of(name, default, context.launch_configurations[name])
            for name, default, _ in arguments}


def parameters_of_noise(values):
    """What is noise, in the unit of the law."""
    law = values['intensity']
    remove_outliers = bool(values['remove_outliers'])
    min_intensity = {'count': 2.0, 'quadratic': 64.0, 'linear': 64.0}.get(law, 0.0)
    if remove_outliers:
        min_intensity = 0.0
    if values['min_intensity'] != '':
        min_intensity = values['min_intensity']
    return {
        'min_intensity': min_intensity,
        'remove_outliers': remove_outliers,
        'density_unit': {'count': 'points', 'quadratic': 'faces'}.get(law, 'automatic'),
    }


def full_intensity_of(values):
    """The intensity that counts as one hit in the map, in the unit of the law."""
    return 4.0 if values['intensity'] == 'count' else 255.0


def parameters_of_sensor(values, names):
    """The parameters of a sensor node that are arguments.

    names are those of texts.
    """
    parameters = {name: values[name] for name in names}
    parameters['resolution'] = values['resolution']
    parameters['i_frame_rate'] = values['i_frame_rate']
    parameters['intensity_bits'] = values['intensity_bits']
    if values['crop_box']:
        parameters['crop_box'] = [float(number) for number in values['crop_box']]
    return parameters


def checked(values):
    """The values, of which respawn and composable exclude each other."""
    if values['respawn'] and values['composable']:
        raise RuntimeError('respawn needs composable:=false: a container that is started '
                           'again comes back without its components')
    return values


def absolute(values, name):
    """A name in the namespace of the launch file, from the root."""
    return '/'.join([''] + [part for part in (values['namespace'].strip('/'), name) if part])


def node(values, plugin, executable, name=None, namespace='', **options):
    """A component, or a process.

    namespace is relative to that of the launch file; name is by default the executable's.
    """
    options.update(name=name or executable, namespace=absolute(values, namespace))
    if values['composable']:
        return ComposableNode(package='pcl_ext_ros', plugin='pcl_ext_ros::' + plugin,
                              extra_arguments=[{'use_intra_process_comms': True}],
                              **options)
    return Node(package='pcl_ext_ros', executable=executable, output='screen',
                respawn=values['respawn'], respawn_delay=1.0, **options)


def started(values, nodes):
    """Nodes as they are, or components in a container."""
    if not values['composable']:
        return nodes
    # Of several threads, so that merging and the map do not delay frames.
    return [ComposableNodeContainer(package='rclcpp_components',
                                    executable='component_container_mt',
                                    name=values['container'],
                                    namespace=absolute(values, ''),
                                    composable_node_descriptions=nodes,
                                    output='screen')]
