"""The figures of chapter 3, and where ours stand."""

from __future__ import annotations

from collections.abc import Iterator

from avsec_gym.experiments.chapter3.settings import SCENARIOS
from avsec_gym.experiments.chapter3.thesis import (
    DETECTION,
    ERROR_BOUNDS,
    IDENTIFICATION,
    OBJECT_LEVEL,
)
from studies.reproduce.rows import (
    MOST,
    NEARLY_ALL,
    Claim,
    DataKind,
    Measured,
    ThesisRow,
    Unit,
    measured,
)
from studies.result_fields import ResultField, field, row

_LIDAR, _CAMERAS = SCENARIOS
"""The thesis' scenarios 1 and 2."""
_MATCHERS = {"identification_sgbm": "semi-global matching", "identification_psmnet": "PSMNet"}
"""Result -> matcher."""
_CRITERIA = {"error": "E alone", "any": "four shares"}
_METHODS = {
    "algorithm 2, error": "algorithm 2 by E alone",
    "algorithm 2, any": "algorithm 2 by four shares",
    "maximum likelihood": "maximum likelihood",
}
_CASES_IN_THESIS = {
    _LIDAR: {"S0": "S0", "S1": "S2", "S2": "S3", "S1+S2": "S2+S3"},
    _CAMERAS: {"S0": "S1", "S1": "S2", "S2": "S3", "S1+S2": "S2+S3"},
}
"""Scenario -> the thesis' name of attacked sensors -> ours: our sensors are those of four."""
_READ = {"most": MOST, "virtually all": NEARLY_ALL, "99 %": 0.99, "all": NEARLY_ALL}
"""Words of `ERROR_BOUNDS` -> how they are read."""
_REAL_FRAME = "000107"


def chapter3_rows() -> list[ThesisRow]:
    """All of them, in the thesis' order."""
    return [
        *_impact(),
        *_errors("Figure 3.5", _LIDAR, 0),
        *_cases(),
        *_errors("Figure 3.7", _CAMERAS, 1),
        *_detection(),
        *_baseline(),
        *_errors_of_four(),
        *_curves_of_identification(),
        *_identification(),
        *_sensitivity(),
    ]


def _impact() -> Iterator[ThesisRow]:
    """Section 3.2.4."""
    real = field("identification_real", "impact", "pixor")
    believed = field("believed", "believed", "rows")
    yield ThesisRow(
        "Section 3.2.4",
        "bogus returns that PIXOR takes for an obstacle",
        0.986,
        (
            *(
                measured(
                    real.then(column),
                    DataKind.REAL,
                    "real_frames",
                    where,
                    clusters=real.then("frames"),
                )
                for column, where in (("taken", "a plane"), ("car_taken", "a car's scan"))
            ),
            *(
                measured(
                    believed.then(row(detector="pixor", kind=kind), "taken"),
                    DataKind.PROCEDURAL,
                    "believed",
                    where,
                )
                for kind, where in (("plane", "a plane"), ("car", "a car's scan"))
            ),
        ),
    )
    for state, thesis in (("clean", 84.62), ("attacked", 61.53)):
        yield ThesisRow(
            "Section 3.2.4",
            f"AP of cars by Faster R-CNN, IoU 0.5, {state}",
            thesis,
            _precisions("impact", field("optical_attacks", "impact", "camera", state)),
            unit=Unit.PERCENT,
        )


def _precisions(experiment: str, place: ResultField) -> tuple[Measured, ...]:
    """Average precision at each level: the thesis does not name its own."""
    return tuple(
        measured(place.then(level), DataKind.PROCEDURAL, experiment, level, "value")
        for level in ("easy", "moderate", "hard")
    )


def _errors(place: str, scenario: str, number: int) -> Iterator[ThesisRow]:
    """Figures 3.5 and 3.7: where E lies."""
    bounds = ERROR_BOUNDS[SCENARIOS[scenario]]
    for column, what, said in (
        ("clean_below", f"clean frames with E below {100 * bounds.clean_below:g} %", bounds.clean),
        (
            "attacked_above",
            f"attacked frames with E above {100 * bounds.attacked_above:g} %",
            bounds.attacked,
        ),
    ):
        steps = ("validation", "case_distributions", number, column)
        yield ThesisRow(
            place,
            f"{scenario}: {what}",
            _READ[said],
            tuple(
                measured(field(result, *steps), DataKind.PROCEDURAL, "identification", matcher)
                for result, matcher in _MATCHERS.items()
            ),
            Claim.AT_LEAST,
            said=said,
        )


def _cases() -> Iterator[ThesisRow]:
    """Figures 3.6 and 3.8, at r = 1 %: detection where one sensor is attacked, or two cameras."""
    for place, scenario, least in (
        ("Figure 3.6", _LIDAR, {"S1": 0.995, "S1+S2": 0.995}),
        ("Figure 3.8", _CAMERAS, {}),
    ):
        for case, ours in _CASES_IN_THESIS[scenario].items():
            yield ThesisRow(
                place,
                f"{scenario}: attacks on {case} that are detected, r = 1 %",
                least.get(case, 1.0),
                (
                    *(_real_case(case, name) for name in _CRITERIA if scenario == _LIDAR),
                    *(
                        Measured(
                            _detected(result, scenario, 0.01, name).then("cases", ours),
                            DataKind.PROCEDURAL,
                            "identification",
                            f"{criterion} with {matcher}",
                            # Each frame is of a drive of its own: they are independent.
                            cases=field(result, "validation", "drives", "judged"),
                        )
                        for result, matcher in _MATCHERS.items()
                        for name, criterion in _CRITERIA.items()
                    ),
                ),
                Claim.AT_LEAST,
            )


def _real_case(case: str, criterion: str) -> Measured:
    """Of one real frame, attacked again and again."""
    frames = field("identification_real", "frames")
    return measured(
        frames.then(_REAL_FRAME, "cases", case, criterion),
        DataKind.REAL,
        "real_frames",
        f"{_CRITERIA[criterion]} on one real frame",
        clusters=frames,
    )


def _detected(result: str, scenario: str, rate: float, criterion: str) -> ResultField:
    return field(
        result, "validation", "detection", row(scenario=scenario, rate=rate, criterion=criterion)
    )


def _detection() -> Iterator[ThesisRow]:
    """Table 3.1, the thesis' method."""
    for (scenario, rate), thesis in DETECTION.items():
        yield ThesisRow(
            "Table 3.1",
            f"{scenario}: attacks detected, r = {100 * rate:g} %",
            thesis,
            tuple(
                measured(
                    _detected(result, scenario, rate, name),
                    DataKind.PROCEDURAL,
                    "identification",
                    f"{criterion} with {matcher}",
                    "average",
                )
                for result, matcher in _MATCHERS.items()
                for name, criterion in _CRITERIA.items()
            ),
            Claim.AT_LEAST,
        )


def _baseline() -> Iterator[ThesisRow]:
    """Table 3.1, the baseline: by any mismatch, and by more of them than 1 % of clean frames."""
    rows = field("optical_attacks", "baseline", "rows")
    for (scenario, iou), thesis in OBJECT_LEVEL.items():
        yield ThesisRow(
            "Table 3.1",
            f"{scenario}: attacks detected by mismatches of objects, IoU {iou:g}",
            thesis,
            tuple(
                measured(
                    rows.then(row(scenario=scenario, iou=iou, rate=rate)),
                    DataKind.PROCEDURAL,
                    "object_level",
                    where,
                    "average",
                )
                for rate, where in ((None, "any mismatch"), (0.01, "r = 1 %"))
            ),
        )


def _errors_of_four() -> Iterator[ThesisRow]:
    """Figure 3.9: E of the first triple of four sensors."""
    bounds = ERROR_BOUNDS[0, 1, 3]
    for column, what, said in (
        ("clean_below", f"clean frames with E below {100 * bounds.clean_below:g} %", bounds.clean),
        (
            "attacked_above",
            f"attacked frames with E above {100 * bounds.attacked_above:g} %",
            bounds.attacked,
        ),
    ):
        steps = ("validation", "reference_distributions", 0, column)
        yield ThesisRow(
            "Figure 3.9",
            f"S0, S1 and S3: {what}",
            _READ[said],
            tuple(
                measured(field(result, *steps), DataKind.PROCEDURAL, "identification", matcher)
                for result, matcher in _MATCHERS.items()
            ),
            Claim.AT_LEAST,
            said=said,
        )


def _identified(result: str, method: str, rate: float) -> ResultField:
    return field(result, "validation", "identification", row(method=method, rate=rate))


def _curves_of_identification() -> Iterator[ThesisRow]:
    """Figure 3.10."""
    for sensor, rate, thesis, claim, said in (
        ("S3", 0.5, NEARLY_ALL, Claim.AT_LEAST, "very close to 100 %"),
        *(
            (sensor, 1.0, 1 - NEARLY_ALL, Claim.AT_MOST, "drops linearly")
            for sensor in ("S0", "S1", "S2")
        ),
    ):
        yield ThesisRow(
            "Figure 3.10",
            f"attacks on {sensor} identified, r = {100 * rate:g} %",
            thesis,
            tuple(
                measured(
                    _identified(result, "algorithm 2, error", rate).then("sensors", sensor),
                    DataKind.PROCEDURAL,
                    "identification",
                    matcher,
                )
                for result, matcher in _MATCHERS.items()
            ),
            claim,
            said=said,
        )


def _identification() -> Iterator[ThesisRow]:
    """Table 3.2."""
    for rate, values in IDENTIFICATION.items():
        *of_sensors, average = values
        for number, thesis in enumerate(of_sensors):
            yield ThesisRow(
                "Table 3.2",
                f"attacks on S{number} identified, r = {100 * rate:g} %",
                thesis,
                _by_every_method(rate, ("sensors", f"S{number}"), "rate"),
                Claim.AT_LEAST,
            )
        yield ThesisRow(
            "Table 3.2",
            f"attacks identified on average, r = {100 * rate:g} %",
            average,
            _by_every_method(rate, (), "average"),
            Claim.AT_LEAST,
        )


def _by_every_method(rate: float, steps: tuple[str, ...], value: str) -> tuple[Measured, ...]:
    return tuple(
        measured(
            _identified(result, method, rate).then(*steps),
            DataKind.PROCEDURAL,
            "identification",
            f"{name} with {matcher}",
            value,
        )
        for result, matcher in _MATCHERS.items()
        for method, name in _METHODS.items()
    )


def _sensitivity() -> Iterator[ThesisRow]:
    """Figures 3.11 and 3.12."""
    lidar = field("optical_attacks", "sensitivity", "lidar", "sizes")
    for width in (1.5, 2.0, 2.5):
        yield _detected_by_size(
            "Figure 3.11",
            f"bogus returns {width:g} m wide",
            lidar.then(row(size=width)),
            NEARLY_ALL,
            "nearly 100 %",
        )
    yield ThesisRow(
        "Figure 3.11",
        "AP that PointRCNN loses to bogus returns 1.5 m wide",
        6.0,
        tuple(
            measured(
                lidar.then(row(size=1.5), "precision", level),
                DataKind.PROCEDURAL,
                "sensitivity",
                level,
                "lost",
                "lost_interval",
            )
            for level in ("easy", "moderate", "hard")
        ),
        Claim.AT_MOST,
        Unit.PERCENT,
    )
    camera = field("optical_attacks", "sensitivity", "camera", "sizes", row(size=187.5))
    covered = "faculae of 23.71 % of the image"
    yield _detected_by_size("Figure 3.12", covered, camera, 0.9, "over 90 %")
    yield ThesisRow(
        "Figure 3.12",
        f"AP of YOLOv3 under {covered}",
        54.12,
        _precisions("sensitivity", camera.then("precision")),
        unit=Unit.PERCENT,
    )


def _detected_by_size(
    place: str, what: str, size: ResultField, thesis: float, said: str
) -> ThesisRow:
    """Detection of attacks of one size, r = 1 %."""
    return ThesisRow(
        place,
        f"{what} that are detected, r = 1 %",
        thesis,
        tuple(
            measured(size.then("detected", name), DataKind.PROCEDURAL, "sensitivity", criterion)
            for name, criterion in _CRITERIA.items()
        ),
        Claim.AT_LEAST,
        said=said,
    )
