"""Cycloidal gearboxes by their drawing: what is stated, what follows from it, and what is still
unknown, one file per part of the drive.
"""

from lostmotion.parts.gearbox.cycloidal.gearbox import CycloidalGearbox as CycloidalGearbox
