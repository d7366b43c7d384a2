"""Gearboxes, one file per kind. A line here makes a kind known to arm files, their schema, and
every analysis.
"""

from lostmotion.parts.gearbox.ball_screw import BallScrew as BallScrew
from lostmotion.parts.gearbox.belt import BeltDrive as BeltDrive
from lostmotion.parts.gearbox.belt import BeltStage as BeltStage
from lostmotion.parts.gearbox.catalogue import CatalogueGearbox as CatalogueGearbox
from lostmotion.parts.gearbox.cycloidal import CycloidalGearbox as CycloidalGearbox
from lostmotion.parts.gearbox.planetary import PlanetaryGearbox as PlanetaryGearbox
from lostmotion.parts.gearbox.rack import RackDrive as RackDrive
from lostmotion.parts.gearbox.strain_wave import StrainWaveGearbox as StrainWaveGearbox
from lostmotion.parts.gearbox.wolfrom import WolfromGearbox as WolfromGearbox
from lostmotion.parts.gearbox.worm import WormGearbox as WormGearbox
