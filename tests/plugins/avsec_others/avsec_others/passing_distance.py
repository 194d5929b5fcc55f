"""An experiment: how near ahead may a standing car be, and a planner still passes it?"""

from __future__ import annotations

from collections.abc import Callable

from avsec_gym.boxes import Boxes3D
from avsec_gym.drawing.page_table import Table, figure, name
from avsec_gym.registry import make
from avsec_gym.runs.experiment import Cell, CellResult, Configuration, Experiment, Measurement
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.runs.section import Findings, ReportRequest, Section
from avsec_gym.scenario.builder import build_planning_scenario
from avsec_gym.scenario.intention import Intention

HERE = "avsec_others.passing_distance"
OPTIONS = {"planners": ["astar", "lane_change"], "distances": [8.0, 8.5, 9.0, 9.5, 10.0]}


def cells(configuration: Configuration) -> list[Cell]:
    """A cell for each planner and distance, m."""
    planners, distances = (configuration.options[option] for option in OPTIONS)
    return [Cell.of(f"{HERE}:episodes", planner=p, distance=d) for p in planners for d in distances]


def episodes(configuration: Configuration) -> Callable[[str, float], CellResult]:
    """What does the cells; it is made once in each process."""

    def one_episode(planner: str, distance: float) -> CellResult:
        car = Boxes3D([[0, 1.65, distance]], [[1.5, 1.6, 4]], [-1.57], [1], ["Car"])
        problem = build_planning_scenario(car, intention=Intention.LEFT)
        passes = float(make("planner", planner).plan(problem).found)
        return CellResult(measurements=[Measurement(planner, "left", "passes", passes, distance)])

    return one_episode


def findings(run: RunFolder, request: ReportRequest) -> Findings:
    """The section of the report, and the figures behind it."""
    rows = run.measurements(name="passes", value=1.0)
    nearest = {row.setting: row.strength for row in reversed(rows)}
    if not nearest:
        return Findings()
    sentences = [f"{who} passes a car {near:g} m ahead." for who, near in nearest.items()]
    lines = [[name(who), figure(near)] for who, near in nearest.items()]
    table = Table("Nearest car that is passed", ["planner", "distance, m"], lines)
    section = Section("passing", "Which planner passes the nearest car?", sentences, [table])
    return Findings([section], {"passing_distance": nearest})


QUESTION = "How near ahead may a standing car be, and a planner still passes it?"
PASSING_DISTANCE = Experiment(
    "passing_distance", QUESTION, "", cells, options=OPTIONS, section=f"{HERE}:findings"
)
