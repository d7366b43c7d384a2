"""ISO 9283:1998: the characteristics by their definitions, the test cube, and what robots built would show; never 'certified'."""

from lostmotion.studies.iso9283.characteristics import pose_accuracy, pose_repeatability
from lostmotion.studies.iso9283.expected import expected_repeatability

__all__ = ["expected_repeatability", "pose_accuracy", "pose_repeatability"]
