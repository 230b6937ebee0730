"""Metadata and file lists of the package, for pip and for colcon.

They stand here and not in pyproject.toml because the setuptools of a ROS 2 installation reads only this file.
"""

import os
import runpy
import sys
from pathlib import Path

from setuptools import find_packages, setup

NAME = "follower_humanoid"
HERE = Path(__file__).resolve().parent
TABLE = runpy.run_path(str(HERE / NAME / "executables.py"))
HANDOVER = runpy.run_path(str(HERE / NAME / "ros2_front" / "handover.py"))

PYTHON_REQUIREMENTS = [
    "lz4",
    "matplotlib",
    "mcap",
    "numba>=0.60",
    "numpy",
    "pin>=3.1",
    "pybullet>=3.2.7",  # earlier ones double the torques of the wrist sensors
    "pyyaml",
    "scipy",
    "setproctitle",
    "viser>=1.1,<1.2",  # what `viewer/telling.py` relies on is not documented
    "zstandard",
]
ROS_REQUIREMENTS = [
    "ros-jazzy-common-interfaces>=5.3.6",
    "ros-jazzy-rclpy[fastrtps]>=7.1.6",
]
TEST_REQUIREMENTS = [
    "colcon-core",
    "colcon-ros",
    "mcap-ros2-support",
    "mypy",
    "pip",
    "pytest",
    "pytest-timeout",
    "rosbags",
    "ruff",
    "scipy-stubs",
    "selenium",
    "setuptools>=70.1",
    "types-PyYAML",
]


def ros_is_sourced() -> bool:
    """Whether a ROS 2 installation in this shell brings rclpy: wheels beside it would hide it.

    A Python environment that is named there for the sake of `ros2 run` has rclpy from wheels and is none.
    """
    prefixes = [Path(p) for p in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if p]
    return any((p / "share" / "rclpy").is_dir() and not (p / "pyvenv.cfg").exists() for p in prefixes)


def console_scripts() -> list[str]:
    """What comes into bin/: every executable, and a front for `ros2` where no ROS 2 brings its own."""
    own = [f"{TABLE['console_script'](name)} = {NAME}.nodes.{name}:main" for name in TABLE["EXECUTABLES"]]
    # One that ros2cli has put beside this interpreter would be overwritten.
    folders = [*os.environ.get("PATH", os.defpath).split(os.pathsep), os.path.dirname(sys.executable)]
    if ros_is_sourced() or HANDOVER["real_ros2"](folders) is not None:
        return own
    return [*own, f"ros2 = {NAME}.ros2_front.main:main"]


def shared_files() -> list[tuple[str, list[str]]]:
    """What lies beside the code, each folder with its target under the installation prefix."""
    files = [
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        # `ros2 run` looks here. Files of our own, since pip would put console scripts into bin/.
        (f"lib/{NAME}", [f"scripts/exe/{name}" for name in TABLE["EXECUTABLES"]]),
    ]
    for top in ("config", "launch", "urdf"):
        for folder, _, names in sorted(os.walk(top)):
            paths = [f"{folder}/{name}" for name in sorted(names) if not name.startswith((".", "_"))]
            if paths:
                files.append((f"share/{NAME}/{folder}", paths))
    return files


os.chdir(HERE)
readme = HERE / "README.md"
setup(
    name=NAME,
    version="0.1.0",
    description="A humanoid that walks behind the hand that pulls it, in simulation, as a ROS 2 node graph",
    long_description=readme.read_text(encoding="utf-8") if readme.is_file() else "",
    long_description_content_type="text/markdown",
    license="Apache-2.0",
    maintainer="follower_humanoid maintainers",
    maintainer_email="maintainers@example.org",
    packages=find_packages(include=[NAME, f"{NAME}.*"]),
    package_data={NAME: ["py.typed"]},
    data_files=shared_files(),
    python_requires=">=3.10,<3.13",
    install_requires=PYTHON_REQUIREMENTS + ([] if ros_is_sourced() else ROS_REQUIREMENTS),
    extras_require={"test": TEST_REQUIREMENTS},
    entry_points={"console_scripts": console_scripts()},
    zip_safe=False,
)
