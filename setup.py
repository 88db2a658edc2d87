"""What `src/extperfc` holds becomes importable in the workspace: CMake's catkin_python_setup reads this."""

from setuptools import setup

from catkin_pkg.python_setup import generate_distutils_setup

setup(**generate_distutils_setup(
    packages=["extperfc", "extperfc.arm", "extperfc.arm_markers", "extperfc.calibrate", "extperfc.health", "extperfc.label",
              "extperfc.record", "extperfc.tasks", "extperfc.training",
              "extperfc.training.commands", "extperfc.training.data", "extperfc.training.evaluation",
              "extperfc.training.networks", "extperfc.training.shapes"],
    package_dir={"": "src"},
))
