"""`ros2 launch follower_humanoid bringup.launch.py leader:=fig5 rviz:=true`: bringup with launch arguments.

Bringup itself starts, leads and ends the nodes; this only hands the options on, so that both ways are one.
With `rviz:=true` RViz 2 comes with the layout of the package, and the viewer publishes what it shows.
"""

from launch.actions import DeclareLaunchArgument, EmitEvent, ExecuteProcess, OpaqueFunction
from launch.events import Shutdown
from launch.substitutions import LaunchConfiguration

from follower_humanoid.resources import share_path
from follower_humanoid.ros.launch_options import SWITCHES, WORDS, bringup_command, displays_command
from launch import LaunchDescription

RVIZ = "rviz"


def start(context, *_):
    """Starts bringup and ends the launch with it."""
    values = {name: LaunchConfiguration(name).perform(context) for name in (*WORDS, *SWITCHES, RVIZ)}
    over = EmitEvent(event=Shutdown(reason="the run is over"))
    started = [ExecuteProcess(cmd=bringup_command(values), output="screen", on_exit=[over])]
    if values[RVIZ] == "true":
        layout = str(share_path("config/rviz/follower.rviz"))
        namespace = [f"__ns:=/{values['namespace']}"] if values["namespace"] else []
        remap = ["--ros-args", *(word for name in namespace for word in ("-r", name))]
        started.append(ExecuteProcess(cmd=["rviz2", "-d", layout, *remap], output="log"))
        if values["view"] != "true":
            started.append(ExecuteProcess(cmd=displays_command(values["namespace"]), output="log"))
    return started


def generate_launch_description():
    """Launch arguments and bringup."""
    arguments = [
        DeclareLaunchArgument(name, default_value="", description=text) for name, text in WORDS.items()
    ]
    switches = {**SWITCHES, RVIZ: "RViz 2 with the package's layout"}
    arguments += [
        DeclareLaunchArgument(name, default_value="false", choices=["true", "false"], description=text)
        for name, text in switches.items()
    ]
    return LaunchDescription([*arguments, OpaqueFunction(function=start)])
