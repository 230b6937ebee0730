"""`ros2 launch follower_humanoid follower.launch.py leader:=fig5`: bringup with launch arguments.

Bringup itself starts, leads and ends the nodes; this only hands the options on, so that both ways are one.
"""

from launch.actions import DeclareLaunchArgument, EmitEvent, ExecuteProcess, OpaqueFunction
from launch.events import Shutdown
from launch.substitutions import LaunchConfiguration

from follower_humanoid.ros.launch_options import SWITCHES, WORDS, bringup_command
from launch import LaunchDescription


def start(context, *_):
    """Starts bringup and ends the launch with it."""
    values = {name: LaunchConfiguration(name).perform(context) for name in (*WORDS, *SWITCHES)}
    over = EmitEvent(event=Shutdown(reason="the run is over"))
    return [ExecuteProcess(cmd=bringup_command(values), output="screen", on_exit=[over])]


def generate_launch_description():
    """Launch arguments and bringup."""
    arguments = [
        DeclareLaunchArgument(name, default_value="", description=text) for name, text in WORDS.items()
    ]
    arguments += [
        DeclareLaunchArgument(name, default_value="false", choices=["true", "false"], description=text)
        for name, text in SWITCHES.items()
    ]
    return LaunchDescription([*arguments, OpaqueFunction(function=start)])
