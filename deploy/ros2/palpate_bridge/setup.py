"""The ROS 2 package: `colcon build` installs the node and registers it."""
from setuptools import setup

setup(
    name="palpate_bridge",
    version="0.1.0",
    packages=["palpate_bridge"],
    data_files=[("share/ament_index/resource_index/packages", ["resource/palpate_bridge"]),
                ("share/palpate_bridge", ["package.xml"])],
    entry_points={"console_scripts": ["bridge = palpate_bridge.bridge:main"]},
)
