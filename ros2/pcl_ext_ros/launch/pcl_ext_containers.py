# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Containers that come back with their components when they end."""
from launch.actions import RegisterEventHandler, TimerAction
from launch.event_handlers import OnProcessExit
from launch_ros.actions import ComposableNodeContainer, LoadComposableNodes

RESPAWN_DELAY = 1.0  # s


class _ContextOfContainer:
    """A launch context that is shut down when a container has ended, too."""

    def __init__(self, context, container):
        self._context = context
        self._container = container

    def __getattr__(self, name):
        return getattr(self._context, name)

    @property
    def is_shutdown(self):
        return self._context.is_shutdown or self._container.return_code is not None


class _LoadIntoContainer(LoadComposableNodes):
    """
    Loads components into a container while it runs.

    LoadComposableNodes alone would wait for the answers of one that has ended until the
    shutdown, and occupy one of the few threads of the launch.
    """

    def __init__(self, container, components):
        super().__init__(target_container=container,
                         composable_node_descriptions=components)
        self._container = container

    def execute(self, context):
        return super().execute(_ContextOfContainer(context, self._container))

    def _load_in_sequence(self, requests, context):
        try:
            super()._load_in_sequence(requests, context)
        except Exception:
            # At the shutdown the client is taken away from the thread that uses it.
            if not context.is_shutdown:
                raise


def container(components, name, namespace, respawn, number=1):
    """
    Return a container with components; with respawn it is there again when it has ended.

    components are functions that make a ComposableNode. What launch itself starts again comes
    back empty. Each container has a name of its own: the middleware takes a killed one for
    alive for some seconds, and what was asked of it would not reach one of the same name.
    """
    process = ComposableNodeContainer(
        package='rclcpp_components',
        # Of several threads, so that merging and the map do not delay frames.
        executable='component_container_mt',
        name=name if number == 1 else '{}_{}'.format(name, number),
        namespace=namespace,
        output='screen')

    def start_next(event, context):
        if context.is_shutdown:
            return None
        return [TimerAction(
            period=RESPAWN_DELAY,
            actions=container(components, name, namespace, respawn, number + 1))]

    actions = [process, _LoadIntoContainer(process, [make() for make in components])]
    if respawn:
        actions.insert(0, RegisterEventHandler(OnProcessExit(target_action=process,
                                                             on_exit=start_next)))
    return actions
