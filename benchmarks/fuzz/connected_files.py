"""What connected vehicles send and record, sound, and as a base station and a command read it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

MESSAGE = "message.bin"
SCENARIO = "scenario/641/00069"


def region_message(folder: Path) -> None:
    """Proposals of a vehicle."""
    from avsec_gym.validation.connected.messages.region_message import RegionMessage

    pose = np.eye(4)
    pose[:3, 3] = 30.0, -4.0, 1.7
    _write(folder, RegionMessage(1, pose, _regions(12)).to_bytes())


def crop_message(folder: Path) -> None:
    """Crops of three regions."""
    from avsec_gym.validation.connected.messages.crop_message import CropMessage

    random = np.random.default_rng(0)
    crops = tuple(random.uniform(-2, 2, (count, 3)) for count in (12, 0, 5))
    _write(folder, CropMessage(1, crops).to_bytes())


def claim_message(folder: Path) -> None:
    """Claims in two of twelve regions."""
    from avsec_gym.validation.connected.rays.claim_message import encode_claims
    from avsec_gym.validation.connected.rays.claims import Claims

    voxel = np.r_[np.arange(0, 60, 3), np.arange(5, 15)]
    velocity = np.array([[3.0, -1.0], [0.0, 0.0]])
    claims = Claims(np.array([2, 7]), velocity, np.array([20, 10]), voxel)
    _write(folder, encode_claims(claims))


def count_message(folder: Path) -> None:
    """What a witness reports of six claims."""
    from avsec_gym.validation.connected.rays.witness_counts import WitnessCounts, encode_counts

    counts = np.random.default_rng(0).integers(0, 40, (6, 3))
    _write(folder, encode_counts(WitnessCounts(np.arange(0, 12, 2), counts)))


def opv2v(folder: Path) -> None:
    """Two vehicles and one instant."""
    random = np.random.default_rng(0)
    for number, name in enumerate(("641", "650")):
        place = folder / "scenario" / name
        place.mkdir(parents=True)
        pose = [20.0 * number, 3.0, 1.9, 0.0, 90.0 * number, 0.0]
        (place / "00069.yaml").write_text(
            "camera0:\n  cords: [1.0, 2.0, 3.0]\nego_speed: 36.0\n"
            + _listed("lidar_pose", pose)
            + "vehicles:\n  1732:\n"
            + _listed("angle", [0.0, 30.0, 0.0], "    ")
            + _listed("center", [0.0, 0.0, 0.7], "    ")
            + _listed("extent", [2.2, 0.9, 0.7], "    ")
            + _listed("location", [20.0, 6.0, 0.1], "    ")
            + "    speed: 18.0\n"
        )
        rows = "".join(f"{x:.5g} {y:.5g} {z:.5g} 0.5\n" for x, y, z in random.normal(0, 9, (40, 3)))
        (place / "00069.pcd").write_text(
            "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z intensity\nSIZE 4 4 4 4\nTYPE F F F F\n"
            "COUNT 1 1 1 1\nWIDTH 40\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 40\n"
            f"DATA ascii\n{rows}"
        )


def opv2v_binary(folder: Path) -> None:
    """The same with a binary point cloud."""
    opv2v(folder)
    path = folder / f"{SCENARIO}.pcd"
    header, _ = path.read_text().split("ascii\n")
    points = np.random.default_rng(0).uniform(0, 1, (40, 4)).astype("<f4")
    path.write_bytes(f"{header}binary\n".encode() + points.tobytes())


def read_region_message(folder: Path) -> Any:
    """As the base station does: taken in, merged, and sent to all."""
    from avsec_gym.validation.connected.admission import admitted_proposals
    from avsec_gym.validation.connected.base_station import complete_set_of_regions
    from avsec_gym.validation.connected.messages.region_message import RegionMessage

    message = _decoded(folder, RegionMessage.from_bytes)
    complete = complete_set_of_regions(admitted_proposals([message]))
    complete.to_bytes()
    return message, complete


def read_crop_message(folder: Path) -> Any:
    """As the base station does: taken in and compared."""
    from avsec_gym.validation.connected.admission import admitted_crops
    from avsec_gym.validation.connected.base_station import region_distances
    from avsec_gym.validation.connected.messages.crop_message import CropMessage
    from avsec_gym.validation.connected.messages.region_message import RegionMessage

    message = _decoded(folder, CropMessage.from_bytes)
    complete = RegionMessage(0, np.eye(4), _regions(3))
    region_distances(complete, admitted_crops([message], complete), 3)
    return message


def read_claim_message(folder: Path) -> Any:
    """As a witness does: decoded, and each voxel's place found."""
    from avsec_gym.validation.connected.rays.claim_message import decode_claims

    regions = _regions(12)
    claims = _decoded(folder, lambda content: decode_claims(content, regions))
    return claims, claims.places(regions)


def read_count_message(folder: Path) -> Any:
    """As the base station does: decoded, and weighed as what one of three vehicles reports."""
    from avsec_gym.validation.connected.rays.decision import DecisionRule, decide
    from avsec_gym.validation.connected.rays.rates import RayRates
    from avsec_gym.validation.connected.rays.witness_counts import decode_counts

    said = _decoded(folder, lambda content: decode_counts(content, _regions(12)))
    counts = np.zeros((12, 3, 3, 3), np.int64)
    counts[said.region, 0, 1] = said.counts
    decide(counts, RayRates(), DecisionRule())
    return said


def read_opv2v(folder: Path) -> Any:
    """As a command does: every instant of the first scenario."""
    from avsec_gym.validation.connected.opv2v.scenario_folders import (
        find_scenarios,
        opv2v_instants,
    )

    return list(opv2v_instants(find_scenarios(folder)[0]))


def error_model(path: Path) -> None:
    """Errors of a detector with ghosts."""
    from avsec_gym.closed_loop.error_model.model import ErrorModel, Ghosts, write_error_model

    ghosts = Ghosts(0.3, ((12.0, 1.5, 0.1, 1.5, 1.6, 4.0), (30.0, -3.0, 0.0, 1.4, 1.7, 3.9)), 0.4)
    write_error_model(path, ErrorModel(ghosts=ghosts, card={"detector": "dsgn"}))


def read_error_model(folder: Path) -> Any:
    """As the closed loop does."""
    from avsec_gym.closed_loop.error_model.model import read_error_model

    return read_error_model(folder / "dsgn.json")


def connected_fit(path: Path) -> None:
    """The package's own, as `avsec connected --constants` takes another one."""
    from avsec_gym.validation.connected.fit import SHIPPED_FIT

    path.write_bytes(SHIPPED_FIT.read_bytes())


def read_connected_fit(folder: Path) -> Any:
    """What vehicles decide by."""
    from avsec_gym.validation.connected.fit import read_connected_fit

    return read_connected_fit(folder / "fit.json").constants()


def learned_fit(path: Path) -> None:
    """The package's own, as `avsec connected --method learned --model` takes another one."""
    from avsec_gym.validation.connected.learned.learned_fit import SHIPPED_MODEL

    path.write_bytes(SHIPPED_MODEL.read_bytes())


def read_learned_fit(folder: Path) -> Any:
    """What a base station decides by: the threshold, the model, a region's log odds, the origin."""
    from avsec_gym.validation.connected.learned.features import FEATURES
    from avsec_gym.validation.connected.learned.learned_fit import read_learned_fit

    fit = read_learned_fit(folder / "learned.json")
    regions = np.stack([np.zeros(len(FEATURES)), np.ones(len(FEATURES))])
    assert fit.origin
    return fit.rule(0.1).model, fit.model.log_odds(regions), fit.card


def _decoded(folder: Path, decode: Callable[[bytes], Any]) -> Any:
    """A message out of a file; one that is refused is named by the file."""
    from avsec_gym.errors import DataError
    from avsec_gym.storage.regular_files import read_bytes

    path = folder / MESSAGE
    content = read_bytes(path, most=16 * 2**20)
    try:
        return decode(content)
    except DataError as error:
        raise DataError(error.problem, path=path, remedy=error.remedy) from error


def _write(folder: Path, content: bytes) -> None:
    (folder / MESSAGE).write_bytes(content)


def _regions(count: int) -> Any:
    from avsec_gym.validation.connected.regions import Regions

    random = np.random.default_rng(1)
    places = np.c_[random.uniform(-40, 40, (count, 2)), np.zeros(count)]
    return Regions(places, np.tile([4.0, 1.8, 1.5], (count, 1)), random.uniform(-3, 3, count))


def _listed(key: str, values: list[float], indent: str = "") -> str:
    return f"{indent}{key}:\n" + "".join(f"{indent}- {value}\n" for value in values)
