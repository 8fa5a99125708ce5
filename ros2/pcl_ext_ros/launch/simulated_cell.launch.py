# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""
The paper's robot cell, a sensor node for each sensor, and one central node.

Six simulated Kinect V2 are in the poses of the paper's Table 1. The arguments are those of
six_sensors.launch.py.
"""
import os

from launch import LaunchDescription
from launch.actions import IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource


def generate_launch_description():
    """Return the launch file of six sensors with those of the simulated cell."""
    six_sensors = os.path.join(os.path.dirname(__file__), 'six_sensors.launch.py')
    return LaunchDescription([
        IncludeLaunchDescription(PythonLaunchDescriptionSource(six_sensors),
                                 launch_arguments=[('simulated', 'true')])])
