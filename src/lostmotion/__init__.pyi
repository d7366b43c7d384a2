"""Public names with their homes: the questions, reading, their results, then the pieces in between, then what can go wrong."""

# isort: off
# fmt: off
from lostmotion.analyses.accuracy.command import study as study
from lostmotion.analyses.workspace_map.command import map as map
from lostmotion.analyses.iso9283.command import iso9283 as iso9283
from lostmotion.analyses.targets.command import target as target
from lostmotion.analyses.sizing.command import size as size
from lostmotion.analyses.statics.command import statics as statics
from lostmotion.analyses.task.command import task as task
from lostmotion.analyses.calibrate.command import calibrate as calibrate
from lostmotion.analyses.gearbox.command import gear as gear
from lostmotion.analyses.bearing.command import bearing as bearing
from lostmotion.analyses.view.command import view as view
from lostmotion.analyses.new.command import new as new
from lostmotion.analyses.check.command import check as check
from lostmotion.analyses.catalog.command import catalog as catalog
from lostmotion.analyses.compare.command import compare as compare
from lostmotion.analyses.sweep.command import sweep as sweep
from lostmotion.analyses.replay.command import replay as replay
from lostmotion.analyses.compensate.command import compensate as compensate
from lostmotion.analyses.export.command import export_c as export_c
from lostmotion.analyses.export.command import export_fmu as export_fmu
from lostmotion.analyses.export.command import export_ros2 as export_ros2
from lostmotion.analyses.schema.command import schema as schema
from lostmotion.analyses.read import read as read
from lostmotion.analyses.export.model import controller as controller
from lostmotion.analyses.accuracy.result import AnalyticStudy as AnalyticStudy, Study as Study
from lostmotion.analyses.workspace_map.page import AccuracyMap as AccuracyMap
from lostmotion.analyses.iso9283.result import Iso9283 as Iso9283
from lostmotion.analyses.targets.targets import Target as Target
from lostmotion.analyses.targets.targets import production_yield as production_yield
from lostmotion.analyses.sizing.selection import Selection as Selection
from lostmotion.analyses.sizing.sizing import Size as Size
from lostmotion.analyses.statics.page import Statics as Statics
from lostmotion.analyses.task.outcome import TaskResult as TaskResult
from lostmotion.analyses.calibrate.result import Calibrated as Calibrated, CalibrationPlan as CalibrationPlan, MakerCalibration as MakerCalibration
from lostmotion.analyses.gearbox.gear import Gear as Gear
from lostmotion.analyses.bearing.command import BearingStudy as BearingStudy
from lostmotion.analyses.catalog.command import Catalog as Catalog
from lostmotion.analyses.compare.page import Compare as Compare
from lostmotion.analyses.sweep.page import Sweep as Sweep
from lostmotion.analyses.replay.page import Replayed as Replayed
from lostmotion.mechanism.arm import Arm as Arm
from lostmotion.mechanism.tool import Payload as Payload, Tool as Tool
from lostmotion.mechanism.state import State as State, state_of as state_of
from lostmotion.mechanism.holding_torques import worst_torques_over_tilts as worst_torques_over_tilts
from lostmotion.mechanism.elastostatics import ellipsoid as ellipsoid
from lostmotion.mechanism.calibration import Calibration as Calibration
from lostmotion.error_model.poses import Poses as Poses, sample_poses as sample_poses
from lostmotion.error_model.bounds import worst_case as worst_case
from lostmotion.error_model.pose_matrix import screws as screws
from lostmotion.errors import DidNotConvergeError as DidNotConvergeError, InputError as InputError
from lostmotion.errors import LostmotionError as LostmotionError, OutputExistsError as OutputExistsError

__version__: str
HOMES: dict[str, str]
QUESTIONS: dict[str, str]
