"""The figures of chapter 5, and where ours stand."""

from __future__ import annotations

from collections.abc import Iterator

from avsec_gym.experiments.chapter5.section.answer_in_words import NARROW
from avsec_gym.experiments.thesis import (
    INTENTIONS,
    LEVELS,
    NAMES,
    PRECISION,
    SAFE_DRIVING_WITH_GROUND_TRUTH,
    SAFETY,
)
from avsec_gym.planners.planner import Algorithm
from avsec_gym.scenario.intention import Intention
from studies.reproduce.rows import NEARLY_ALL, Claim, DataKind, Measured, ThesisRow, Unit, measured
from studies.result_fields import ResultField, field, row

_TWINS = "chapter5"
_RATES = {
    "success": "success_rate",
    "collision": "collision_rate",
    "safe": "safe_driving_rate",
}
"""The thesis' rates -> columns of results."""
_SLIPS = {("dsgn", "thesis_pgd-1-3", Intention.STRAIGHT, "safe")}
"""The safe driving rate does not follow from success and collisions of the same column."""
_FIGURE_OF_TEXTURE = {"stereo_rcnn": "Figure 5.6", "dsgn": "Figure 5.7"}
_ALGORITHMS = {Algorithm.ASTAR: "A*", Algorithm.GBFS: "Greedy-BFS"}
_SPECIFIC = "patch-specific-"
"""The name of a specific patch, before the intention that it is placed for."""


def chapter5_rows() -> list[ThesisRow]:
    """All of them, in the thesis' order."""
    return [
        *_classifiers(),
        *_safety(),
        *_precision(),
        *_intentions(),
        *_planners(),
        *_inputs(),
        *_decoupling(),
        *_ghosts(),
        *_pyramid(),
        *_spread(),
    ]


def _classifiers() -> Iterator[ThesisRow]:
    """Section 5.3.1."""
    motion, road = field("classifiers", "motion"), field("classifiers", "road_type")
    flags = motion.then("real", "flags_of_scenarios")
    for what, thesis, real, clusters, world in (
        (
            "objects whose motion is classified rightly",
            0.9831,
            flags.then("single_crop"),
            flags.then("frames"),
            motion.then("world", "with_neighbour"),
        ),
        (
            "scenes whose road type is classified rightly",
            0.9464,
            road.then("real"),
            road.then("real", "frames"),
            road.then("world"),
        ),
    ):
        yield ThesisRow(
            "Section 5.3.1",
            what,
            thesis,
            (
                measured(real, DataKind.REAL, "classifiers", value="accuracy", clusters=clusters),
                measured(world, DataKind.PROCEDURAL, "classifiers", value="accuracy"),
            ),
            Claim.AT_LEAST,
        )


def _safety() -> Iterator[ThesisRow]:
    """Tables 5.1, 5.2 and 5.4."""
    for (detector, setting, intention), rates in SAFETY.items():
        columns = row(**_condition(setting), detector=detector, intention=str(intention))
        for rate, column in _RATES.items():
            yield ThesisRow(
                _table_of(setting),
                f"{NAMES[detector]}, {_name(setting)}, {intention}: {_words(column)}",
                getattr(rates, rate),
                (_twin(field(_TWINS, "safety", columns), column, _experiment(setting)),),
                slip=(detector, setting, intention, rate) in _SLIPS,
            )


def _precision() -> Iterator[ThesisRow]:
    """Figure 5.3 and table 5.3: AP in 3D at IoU 0.7, with 11 recalls as in the papers."""
    for (detector, setting), values in PRECISION.items():
        specific = setting.startswith(_SPECIFIC)
        columns = row(
            **_condition("patch-specific" if specific else setting),
            detector=detector,
            intention=setting.removeprefix(_SPECIFIC) if specific else None,
        )
        place = field(_TWINS, "precision", columns, "precision", "3d")
        for number, (level, thesis) in enumerate(zip(LEVELS, values, strict=True)):
            yield ThesisRow(
                "Figure 5.3" if setting.startswith("thesis_pgd") else "Table 5.3",
                f"{NAMES[detector]}, {_name(setting)}: AP of cars, {level}",
                round(100 * thesis, 2),
                (
                    Measured(
                        place.then("ap11", number),
                        DataKind.TWIN,
                        _experiment(setting),
                        interval=place.then("ap11_interval", number),
                    ),
                ),
                unit=Unit.PERCENT,
            )
    for number, level in enumerate(LEVELS):
        columns = row(**_condition("thesis_pgd-0.4-3"), detector="dsgn", intention=None)
        place = field(_TWINS, "precision", columns, "precision", "3d")
        yield ThesisRow(
            "Figure 5.3",
            f"DSGN, {_name('thesis_pgd-0.4-3')}: AP of cars, {level}",
            1.0,
            (
                Measured(
                    place.then("ap11", number),
                    DataKind.TWIN,
                    "perturbation",
                    interval=place.then("ap11_interval", number),
                ),
            ),
            Claim.AT_MOST,
            Unit.PERCENT,
            said="almost reaches 0",
        )


def _intentions() -> Iterator[ThesisRow]:
    """Table 5.5."""
    for group, rates in INTENTIONS.items():
        columns = row(detector="stereo_rcnn", attack="patch-random", group=group)
        for rate, column in _RATES.items():
            yield ThesisRow(
                "Table 5.5",
                f"Stereo R-CNN under patches, {group}: {_words(column)}",
                getattr(rates, rate),
                (_twin(field(_TWINS, "intentions", columns), column, "patch"),),
            )


def _planners() -> Iterator[ThesisRow]:
    """Table 5.6: the planner knows the truth."""
    for (algorithm, intention), thesis in SAFE_DRIVING_WITH_GROUND_TRUTH.items():
        columns = row(planner=str(algorithm), intention=str(intention))
        yield ThesisRow(
            "Table 5.6",
            f"{_ALGORITHMS[algorithm]}, {intention}: safe driving rate",
            thesis,
            tuple(
                measured(
                    field("driving_safety", group, columns),
                    DataKind.REAL,
                    "driving_safety",
                    where,
                    "safe_driving_rate",
                    "safe_driving_rate_interval",
                )
                for group, where in (
                    ("ground_truth", "all scenarios"),
                    ("without_scenes_without_cars", "scenarios with cars"),
                )
            ),
            Claim.AT_LEAST,
        )


def _inputs() -> Iterator[ThesisRow]:
    """Table 5.7."""
    for intention in Intention:
        truth = SAFE_DRIVING_WITH_GROUND_TRUTH[Algorithm.ASTAR, intention]
        yield _input(None, "unattacked", intention, truth)
        for detector in NAMES:
            for setting in ("unattacked", "thesis_pgd-1-4", "patch-random"):
                rates = SAFETY[detector, setting, intention]
                yield _input(detector, setting, intention, rates.safe)


def _input(detector: str | None, setting: str, intention: Intention, thesis: float) -> ThesisRow:
    columns = row(**_condition(setting, False), detector=detector, intention=str(intention))
    name = "ground truth" if detector is None else f"{NAMES[detector]}, {_name(setting)}"
    return ThesisRow(
        "Table 5.7",
        f"{name}, {intention}: safe driving rate",
        thesis,
        (_twin(field(_TWINS, "inputs", columns), "safe_driving_rate", "inputs"),),
        Claim.AT_LEAST if detector is None else Claim.IS,
    )


def _decoupling() -> Iterator[ThesisRow]:
    """Section 5.4.5: precision and safety are decoupled where their correlation is near zero."""
    for detector, name in NAMES.items():
        yield ThesisRow(
            "Section 5.4.5",
            f"{name}: rank correlation of precision lost and safety lost, over attacks",
            NARROW,
            (
                measured(
                    field(_TWINS, "decoupling", "rank_correlation", detector),
                    DataKind.TWIN,
                    "chapter5",
                    value="rho",
                ),
            ),
            Claim.AT_MOST,
            Unit.NUMBER,
            said="decoupled",
        )


def _ghosts() -> Iterator[ThesisRow]:
    """Section 5.5.1, figures 5.6 and 5.7."""
    for detector, network in NAMES.items():
        name = f"{network}, {_name('thesis_pgd-1-4')}"
        columns = row(**_condition("thesis_pgd-1-4"), detector=detector)
        place = field(_TWINS, "ghosts", columns)
        yield ThesisRow(
            "Section 5.5.1",
            f"{name}: ghosts on the road",
            1 - NEARLY_ALL,
            (_twin(place, "share_on_road", "ghost_positions"),),
            Claim.AT_MOST,
            said="almost all appear in the side areas",
        )
        yield ThesisRow(
            "Section 5.5.1",
            f"{name}: ghosts on the road, of what chance would have there",
            1.0,
            (_twin(place, "ratio", "ghost_positions"),),
            Claim.AT_MOST,
            Unit.NUMBER,
            said="tend to appear in the side areas",
        )
        columns = row(attack="texture-thesis_pgd-1", strength=4.0, detector=detector)
        yield ThesisRow(
            _FIGURE_OF_TEXTURE[detector],
            f"{name}, side areas like the road: ghosts beside it in a frame",
            0.0,
            (_twin(field(_TWINS, "seen", columns), "ghosts_beside", "texture"),),
            Claim.AT_MOST,
            Unit.NUMBER,
            said="no more ghost boxes",
        )


def _pyramid() -> Iterator[ThesisRow]:
    """Section 5.5.2."""
    yield ThesisRow(
        "Section 5.5.2",
        "AP that a patch takes from DSGN without its pyramid, beyond what it takes with it",
        0.0,
        claim=Claim.AT_LEAST,
        unit=Unit.PERCENT,
        said="the module restrains the impact of the patch",
    )


def _spread() -> Iterator[ThesisRow]:
    """Figure 5.8."""
    for detector, layer, column, thesis, claim, unit, what, said in (
        (
            "stereo_rcnn", "maxpool1", "share", NEARLY_ALL, Claim.AT_LEAST, Unit.SHARE,
            "share of the map that the patch moves", "almost the entire cropped image",
        ),
        (
            "dsgn", "fusion2", "radius", 38.0, Claim.AT_MOST, Unit.NUMBER,
            "radius that the patch moves, pixels", "shrinks to its original size",
        ),
    ):  # fmt: skip
        columns = row(detector=detector, patch="joint", images="noise", layer=layer)
        yield ThesisRow(
            "Figure 5.8",
            f"{NAMES[detector]}, {layer}: {what}",
            thesis,
            (
                Measured(
                    field(_TWINS, "spread", columns, column), DataKind.PROCEDURAL, "feature_spread"
                ),
            ),
            claim,
            unit,
            said,
        )


def _twin(place: ResultField, column: str, experiment: str) -> Measured:
    return measured(place, DataKind.TWIN, experiment, value=column, interval=f"{column}_interval")


def _condition(setting: str, levels: bool = True) -> dict[str, str | float | bool]:
    """The columns of a setting such as ``thesis_pgd-0.4-3``: images in float, as in the thesis."""
    attack, strength = setting, 0.0
    if setting.startswith("thesis_pgd"):
        attack, _, steps = setting.rpartition("-")
        strength = float(steps)
    whole: dict[str, str | float | bool] = {"whole_levels": False} if levels else {}
    return {"attack": attack, "strength": strength, **whole}


def _table_of(setting: str) -> str:
    if setting == "unattacked":
        return "Tables 5.1, 5.2, 5.4"
    if setting.startswith("patch"):
        return "Table 5.4"
    return "Table 5.1" if setting.startswith("thesis_pgd-0.4") else "Table 5.2"


def _name(setting: str) -> str:
    if setting.startswith("thesis_pgd"):
        _, alpha, steps = setting.split("-")
        return f"alpha {alpha}, n = {steps}"
    kind, _, intention = setting.removeprefix("patch-").partition("-")
    patch = f"{kind} patch" + (f" for {intention}" if intention else "")
    return setting if setting == "unattacked" else patch


def _experiment(setting: str) -> str:
    if setting == "unattacked":
        return "unattacked"
    return "patch" if setting.startswith("patch") else "perturbation"


def _words(column: str) -> str:
    return column.replace("_", " ")
