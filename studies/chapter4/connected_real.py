"""Real scans half a second apart, as if three vehicles took them: clean, and one tampered with.

Run ``python -m studies.chapter4.connected_real --kitti ROOT --json FILE --images FOLDER``.  The
data of the thesis (section 4.5): three triples of KITTI's raw drive 0052, without measured poses,
so that the scans are registered onto the middle one.  An anecdote: three triples of one place.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from avsec_gym.drawing.connected_picture import save_connected_picture
from avsec_gym.kitti.raw import Drive, KittiRaw
from avsec_gym.validation.connected.attacks.attacked_instant import AttackedInstant, InstantAttack
from avsec_gym.validation.connected.attacks.pasted_object import PastedObject
from avsec_gym.validation.connected.attacks.removed_object import RemovedObject
from avsec_gym.validation.connected.constants import ConnectedConstants
from avsec_gym.validation.connected.fit import SHIPPED_FIT, read_connected_fit
from avsec_gym.validation.connected.raw_drive.drive_instants import DriveInstant, drive_instants
from avsec_gym.validation.connected.rays.decision import CANNOT_TELL, NO_ATTACK
from avsec_gym.validation.connected.validator import ConnectedValidator, Method
from studies.answer import answer

DAY, DRIVE = "2011_09_26", "0052"
MIDDLE = 1
"""The vehicle whose scan is tampered with."""
CLEAN = "clean"
ATTACKS: dict[str, InstantAttack] = {
    "paste": PastedObject(vehicle=MIDDLE, distance=(6.0, 20.0)),
    "removal": RemovedObject(vehicle=MIDDLE),
}
DRAWS = 3
"""Attacks of each kind on each triple."""
WAYS: tuple[tuple[Method, bool], ...] = (("rays", False), ("rays", True), ("surfaces", True))
"""The methods, and whether it is taken as known that all stands: surfaces know of no motion."""
DRAWN = WAYS[1]
PICTURES = {state: f"images/connected_real_{state}.png" for state in ATTACKS}
"""Pictures of the first triple in which rays alarm about what was attacked, else of the first."""


@dataclass(frozen=True)
class RegisteredScan:
    """How a scan lies on the middle one.

    Args:
        middle: Name of the triple, which is that of its middle scan.
        frame: Its frame.
        ahead: How far ahead of the middle one it was taken, metres.
        residual: Median distance of its points from the middle scan's surface, metres.
        overlap: Share of its points on upright surfaces that lie on those of the middle one.
    """

    middle: str
    frame: int
    ahead: float
    residual: float
    overlap: float


@dataclass(frozen=True)
class RealDecision:
    """What a method decides of a triple in a state.

    Args:
        id: Name of the triple.
        state: `CLEAN`, or one of `ATTACKS`.
        method: ``rays`` or ``surfaces``.
        still: Whether it is known that all stood still, as the thesis assumes.
        points: Points that were placed or taken away; 0 of a clean one.
        regions: Number of regions.
        decidable: Number of those in which something was compared.
        alarms: Number of regions that alarm, elsewhere than about what was attacked.
        score: Highest score of the regions about what was attacked; None where there is none, or
            nothing was compared.
        about: What is decided about what was attacked: ``victim``, ``another``, ``cannot tell``,
            ``no alarm``, ``not decidable``, ``no region``, or empty of a clean one.
        accused: The vehicles that are named, anywhere.
    """

    id: str
    state: str
    method: str
    still: bool
    points: int
    regions: int
    decidable: int
    alarms: int
    score: float | None
    about: str
    accused: Sequence[int]


@dataclass(frozen=True)
class ConnectedReal:
    """All triples.

    Args:
        drive: Name of the drive.
        scans: How the other two scans of each triple lie on its middle one.
        decisions: A row for each triple, state, method, and whether all is known to stand.
    """

    drive: str
    scans: Sequence[RegisteredScan]
    decisions: Sequence[RealDecision]


def connected_real(
    drive: Drive, images: Path | None = None, seed: int = 0, draws: int = DRAWS
) -> ConnectedReal:
    """Judge all triples of a drive.

    Args:
        drive: The drive.
        images: The folder of `PICTURES`; None: none are drawn.
        seed: Seed of the attacks.
        draws: Number of attacks of each kind on each triple.

    Raises:
        DataError: There are no such scans, or two cannot be registered.
    """
    constants = read_connected_fit(SHIPPED_FIT).constants()
    scans: list[RegisteredScan] = []
    decisions: list[RealDecision] = []
    drawn: dict[str, bool] = {}
    for number, instant in enumerate(drive_instants(drive, poses_by="registration")):
        scans += _registered(instant)
        for state, attacked in _states(instant, (seed, number), draws):
            for method, still in WAYS:
                decides = known_to_stand(constants) if still else constants
                decision, draw = _judged(instant, state, attacked, method, decides, still)
                decisions.append(decision)
                if images is None or state not in PICTURES or (method, still) != DRAWN:
                    continue
                alarms = decision.about in ("victim", "cannot tell")
                if state not in drawn or alarms > drawn[state]:
                    draw(images / Path(PICTURES[state]).name)
                    drawn[state] = alarms
    return ConnectedReal(drive.name, scans, decisions)


def _states(
    instant: DriveInstant, seed: tuple[int, int], draws: int
) -> Iterator[tuple[str, AttackedInstant | None]]:
    """The clean triple, and whatever it offers to attack."""
    yield CLEAN, None
    for state, attack in ATTACKS.items():
        for draw in range(draws):
            attacked = attack.attack(instant, (*seed, draw))
            if attacked is not None:
                yield state, attacked


def known_to_stand(constants: ConnectedConstants) -> ConnectedConstants:
    """The same evidence, where it is known that nothing moves."""
    return replace(constants, margins=replace(constants.margins, fastest=0.0))


def _registered(instant: DriveInstant) -> Iterator[RegisteredScan]:
    for frame, found in zip(instant.frames, instant.registrations, strict=True):
        if found is not None:
            ahead = float(found.transform[0, 3])
            yield RegisteredScan(instant.id, frame, ahead, found.residual, found.overlap)


def _judged(
    instant: DriveInstant,
    state: str,
    attacked: AttackedInstant | None,
    method: Method,
    constants: ConnectedConstants,
    still: bool,
) -> tuple[RealDecision, Callable[[Path], None]]:
    """The decision, and a function that draws it into a file."""
    seen = instant if attacked is None else attacked.instant
    result = ConnectedValidator(constants, method).validate(seen.scans, id=f"{instant.id} {state}")
    about = [] if attacked is None else attacked.regions(result.regions).nonzero()[0].tolist()
    decided = [index for index in about if result.decidable[index]]
    best = max(decided, key=lambda index: float(result.score[index]), default=None)
    if attacked is None:
        what = ""
    elif best is None:
        what = "not decidable" if about else "no region"
    else:
        named = int(result.named[best])
        other = {NO_ATTACK: "no alarm", CANNOT_TELL: "cannot tell", MIDDLE: "victim"}
        what = other.get(named, "another")
    elsewhere = sum(each.index not in about for each in result.accusations)
    decision = RealDecision(
        instant.id,
        state,
        method,
        still,
        0 if attacked is None else attacked.points,
        len(result.regions),
        int(result.decidable.sum()),
        elsewhere,
        None if best is None else float(result.score[best]),
        what,
        result.accused,
    )
    return decision, lambda path: save_connected_picture(
        path, result, seen.scans, constants.margins, about=about
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--kitti", type=Path, required=True, help="the folder with KITTI's `raw`")
    parser.add_argument("--images", type=Path, help="folder of pictures; default: none")
    parser.add_argument("--seed", type=int, default=0, help="of the attacks")
    parser.add_argument("--json", type=Path, help="result file; default: standard output")
    options = parser.parse_args(arguments)

    def run(given: argparse.Namespace) -> ConnectedReal:
        drive = KittiRaw(given.kitti / "raw" / DAY).drive(DRIVE)
        return connected_real(drive, given.images, given.seed)

    return answer(options, run)


if __name__ == "__main__":
    sys.exit(main())
