"""`avsec connected`: which of several vehicles is lied to by its LiDAR?"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from avsec_gym import console
from avsec_gym.commands.left_out import say_left_out
from avsec_gym.commands.named_part import named_part
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.storage.regular_files import is_there

if TYPE_CHECKING:
    from avsec_gym.validation.connected.attacks.attacked_instant import InstantAttack
    from avsec_gym.validation.connected.fit import ConnectedFit
    from avsec_gym.validation.connected.learned.learned_fit import LearnedFit
    from avsec_gym.validation.connected.sources import ConnectedSource
    from avsec_gym.validation.connected.vehicle import RegionProposer
    from avsec_gym.validation.validation_folder import ValidationFolder

_USUAL_OUT = Path("runs/connected")
_WEIGHTS = "proposals_weights"
"""The key of the hash of the weights of the network that proposes, in fits and records."""


@dataclass(frozen=True)
class Connected:
    """Compare the LiDARs of connected vehicles with each other, instant by instant.

    A line for each instant, a picture from above for each alarm, a summary; what was stopped goes
    on, and an instant that has changed since is judged again.  With --fit it measures what the
    evidence is worth on such vehicles instead.
    """

    data: Path | None = None
    """A data set of `avsec world make --suite connected`, a folder in OPV2V's layout, or a drive, a
    day or days in KITTI's raw layout, of which three scans half a second apart stand for three
    vehicles.  Default: a small set of the procedural world, made on first use."""
    method: Literal["rays", "surfaces", "learned"] = "rays"
    """Rays that end on what others claim or pass through it; the thesis' surfaces; or a small model
    that learned to weigh both."""
    poses: Literal["measured", "true", "registration"] = "measured"
    """The poses that align the scans: as the vehicles measure them, the true ones, or by
    registering the scans onto each other (raw drives)."""
    attack: str | None = None
    """Attack one vehicle at each instant: paste, paste_in_path, paste_in_blind_spot, moving_ghost
    (which lasts over a drive), removal, or JSON with arguments such as '{"name": "paste",
    "vehicle": 1, "distance": [6, 20], "laser": "sun_2020"}'."""
    proposals: Literal["clusters", "pointrcnn", "pixor"] = "clusters"
    """Where regions come from: what stands up on the ground; PIXOR, or the first stage of
    PointRCNN, turned to all sides, which take a second or more for a scan."""
    constants: Path | None = None
    """A file that --fit wrote.  Default: the package's own, fitted on the procedural world with
    KITTI's LiDAR."""
    model: Path | None = None
    """A file that --method learned --fit wrote.  Default: the package's own."""
    fit: Path | None = None
    """Measure these instants, which must be without an attack, attack each of them, and write what
    the evidence is worth to this file, or, with --method learned, a model; no instant is judged."""
    alarms: float = 0.1
    """Share of attack-free instants that may alarm by rays, or by the model."""
    rate: float = 0.1
    """Designated false positive rate r of distances, for surfaces."""
    sequence: int | None = None
    """Add up the evidence of so many successive instants of a drive, 0.1 s apart or as they were
    taken, and report each drive, too: a share --alarms of attack-free windows may alarm."""
    seed: int = 0
    """Seed of the attacks."""
    limit: int | None = None
    """Only the first instants."""
    pictures: int = 20
    """Most pictures of alarms."""
    rrd: Path | None = None
    """A file for the Rerun viewer (extra `rerun`), such as alarm.rrd: scans and regions in space of
    the first instant that alarms, or of the first one where none does."""
    out: Path | None = None
    """Folder of frames.jsonl, summary.json and pictures.  Default: runs/connected, or
    runs/connected_2 and so on if that is of something else."""
    json: bool = False
    """JSON lines instead of words, the summary last."""

    def run(self) -> int:
        """Do it; the exit code."""
        self._check()
        if self.fit is not None:
            return self._learn(self.fit) if self.method == "learned" else self._fit(self.fit)
        from avsec_gym.commands.judged_instants import JudgedInstants
        from avsec_gym.commands.judged_sequences import JudgedSequences
        from avsec_gym.validation.connected.validator import ConnectedValidator

        # What decides: the fit, and a model where both kinds of evidence are weighed.
        fit = self._read_fit
        learned = self._read_model if self.method == "learned" else None
        validator = ConnectedValidator(
            fit.constants(self.alarms, self.rate),
            self.method,
            self._proposer,
            learned=None if learned is None else learned.rule(self.alarms),
        )
        self._report_other_weights(fit.data, self._constants_file)
        if learned is not None:
            self._report_other_weights(learned.card.data, self._model_file)
        source = self._source.first(self.limit)
        if not self.json:
            console.say(f"avsec: what decides here was {fit.origin}")
            if learned is not None:
                console.say(f"avsec: the model that weighs it was {learned.origin}")
            if self.method == "rays":
                kept = f"{fit.vouched_alarms(self.alarms):.2g}"
                console.say(
                    f"avsec: these instants vouch for alarms in {kept} of attack-free ones at most"
                    f" (95 % confidence), where --alarms asks for {self.alarms:g}"
                )
        # Judge instant by instant; over a window of each drive, too, where that is asked for.
        with self._locked(fit) as folder:
            judged = JudgedInstants(
                source,
                validator,
                fit,
                folder,
                self._attack,
                self.seed,
                self.pictures,
                self.json,
                self.rrd,
            )
            left_out: dict[str, str] = {}
            drives, sums = judged.judge(left_out), None
            if self.sequence is not None:
                from avsec_gym.validation.connected.rays.sequential import lasting_test

                clean = fit.clean_scores if learned is None else learned.clean_log_odds
                test = lasting_test(clean, self.sequence, self.alarms)
                sums = judged.add_up(JudgedSequences(test, self.sequence), drives)
            return judged.report(drives, left_out, sums)

    def _check(self) -> None:
        for name, good in (
            ("alarms", 0 <= self.alarms < 1),
            ("rate", 0 <= self.rate <= 1),
            ("limit", self.limit is None or self.limit >= 1),
            ("seed", self.seed >= 0),
            ("pictures", self.pictures >= 0),
            ("sequence", self.sequence is None or self.sequence >= 2),
        ):
            if not good:
                raise ConfigurationError(f"--{name} cannot be {getattr(self, name)}")
        if self.rrd is not None:
            self._check_recording(self.rrd)
        constants = self.constants is not None and self.method != "learned"
        if self.fit is not None and (constants or self.attack is not None):
            raise ConfigurationError(
                "--fit measures attack-free instants and attacks them itself: it goes without"
                " --attack and, but for --method learned, without --constants"
            )
        if self.model is not None and (self.method != "learned" or self.fit is not None):
            raise ConfigurationError("--model is for --method learned, which judges by it")
        if self.sequence is not None and (self.method == "surfaces" or self.fit is not None):
            raise ConfigurationError(
                "--sequence adds up log odds of judged instants: it goes with --method rays or"
                " learned, and without --fit"
            )
        if self.fit is not None and is_there(self.fit):
            raise DataError(
                "This file exists and is left as it is.",
                path=self.fit,
                remedy="Name another --fit, or take this file away.",
            )
        # A mistyped name is an error before anything is measured.
        _ = self._attack

    def _check_recording(self, path: Path) -> None:
        from avsec_gym.drawing.rerun_stream import check_rerun

        if self.fit is not None:
            raise ConfigurationError("--fit judges no instant: it goes without --rrd")
        if path.suffix != ".rrd":
            raise ConfigurationError(f"--rrd names a file that ends in .rrd, got {path}")
        check_rerun()

    @cached_property
    def _attack(self) -> InstantAttack | None:
        from avsec_gym.registry import Kind, make

        if self.attack is None:
            return None
        attack: InstantAttack = make(Kind.CONNECTED_ATTACK, named_part(self.attack, "--attack"))
        return attack

    @cached_property
    def _source(self) -> ConnectedSource:
        from avsec_gym.validation.connected.sources import connected_source
        from avsec_gym.world.export import default_suite

        root = self.data
        if root is None:
            with console.progress("rendering instants of connected vehicles") as shown:
                root = default_suite("connected", on_progress=shown)
        return connected_source(root, self.poses)

    @property
    def _constants_file(self) -> Path:
        from avsec_gym.validation.connected.fit import SHIPPED_FIT

        return SHIPPED_FIT if self.constants is None else self.constants

    @cached_property
    def _read_fit(self) -> ConnectedFit:
        from avsec_gym.validation.connected.fit import read_connected_fit

        return read_connected_fit(self._constants_file)

    @property
    def _model_file(self) -> Path:
        from avsec_gym.validation.connected.learned.learned_fit import SHIPPED_MODEL

        return SHIPPED_MODEL if self.model is None else self.model

    @cached_property
    def _read_model(self) -> LearnedFit:
        from avsec_gym.validation.connected.learned.learned_fit import read_learned_fit

        return read_learned_fit(self._model_file)

    @cached_property
    def _proposer(self) -> RegionProposer:
        from avsec_gym.validation.connected.proposals.clusters import ClusterProposer

        if self.proposals == "clusters":
            return ClusterProposer()
        from avsec_gym.registry import Kind, make
        from avsec_gym.validation.connected.proposals.sectors import SectorProposer

        return SectorProposer(make(Kind.DETECTOR, self.proposals))

    @cached_property
    def _weights(self) -> dict[str, str]:
        """What a record has of the weights of the network that proposes; empty without one."""
        detector = getattr(self._proposer, "detector", None)
        if detector is None:
            return {}
        from avsec_gym.perception.weights.weights_hash import weights_hash

        found = weights_hash(detector)
        return {} if found is None else {_WEIGHTS: found}

    def _report_other_weights(self, fitted_on: Mapping[str, Any], file: Path) -> None:
        """Say that a file was fitted on proposals of other weights of the same network.

        Args:
            fitted_on: What names the instants that it was fitted on, see `_record_of_data`.
            file: The file.
        """
        fitted = fitted_on.get(_WEIGHTS)
        if fitted is None or fitted_on.get("proposals") != self.proposals:
            return
        today = self._weights.get(_WEIGHTS)
        if fitted != today:
            console.say(
                f"avsec: {file} was fitted on proposals of other weights of {self.proposals}"
                f" ({str(fitted)[:8]}) than propose here ({str(today)[:8]}): its rates may not"
                " hold for these; `avsec connected --fit` makes one of these"
            )

    def _fit(self, path: Path) -> int:
        """Measure, fit, write; what was measured is kept beside the file until it is written."""
        from avsec_gym import __version__
        from avsec_gym.commands.kept_samples import kept_samples
        from avsec_gym.runs.fingerprints import fingerprint
        from avsec_gym.validation.connected.fit import write_connected_fit
        from avsec_gym.validation.connected.fitting import FittedInstants, fit_connected

        source = self._source.first(self.limit)
        on = FittedInstants(self._record_of_data(source), self._proposer, seed=self.seed)
        record = {
            "version": __version__,
            "data": str(source.root.resolve()),
            "fingerprint": fingerprint(source.root),
            "poses": self.poses,
            "proposals": self.proposals,
            **self._weights,
            "attacks": [repr(attack) for attack in on.attacks],
            "seed": self.seed,
            "limit": self.limit,
        }
        left_out: dict[str, str] = {}
        with kept_samples(path, record) as samples:
            total = len(source.names) or sum(1 for _ in source.read(left_out))
            with console.progress("measuring instants") as shown:
                instants = source.read(left_out)
                fit = fit_connected(instants, total, on, samples=samples, on_progress=shown)
            say_left_out(left_out, "drives and instants")
            write_connected_fit(path, fit)
        console.say(f"avsec: {path} holds what was {fit.origin}")
        return console.DONE_IN_PART if left_out else console.DONE

    def _learn(self, path: Path) -> int:
        """Measure instants by both methods, fit a model, write it."""
        from avsec_gym.validation.connected.fitting import FittedInstants
        from avsec_gym.validation.connected.learned.learned_fit import write_learned_fit
        from avsec_gym.validation.connected.learned_fitting import fit_learned

        source = self._source.first(self.limit)
        on = FittedInstants(self._record_of_data(source), self._proposer, seed=self.seed)
        left_out: dict[str, str] = {}
        total = len(source.names) or sum(1 for _ in source.read(left_out))
        with console.progress("measuring instants") as shown:
            instants = source.read(left_out)
            fit = fit_learned(instants, total, on, self._read_fit, on_progress=shown)
        say_left_out(left_out, "drives and instants")
        write_learned_fit(path, fit)
        area = f"{fit.card.held_out_area:.3f}"
        console.say(f"avsec: {path} holds what was {fit.origin}; area held out {area}")
        return console.DONE_IN_PART if left_out else console.DONE

    def _record_of_data(self, source: ConnectedSource) -> dict[str, Any]:
        """What names the instants in a fit's file: of our own data sets, their settings."""
        from avsec_gym.world.export import read_manifest

        record: dict[str, Any] = {"layout": source.layout, "proposals": self.proposals}
        record |= {**self._weights, "poses": self.poses}
        settings = (read_manifest(source.root) or {}).get("settings", {})
        named = ("seed", "assets", "vehicles", "clocks_apart", "position_noise", "heading_noise")
        record |= {name: settings[name] for name in named if name in settings}
        return record if settings else {**record, "folder": source.root.name}

    @contextmanager
    def _locked(self, fit: ConnectedFit) -> Iterator[ValidationFolder]:
        """The folder of the results, which no other process writes meanwhile."""
        from avsec_gym import __version__
        from avsec_gym.commands.instant_rows import InstantRow
        from avsec_gym.commands.named_files import named_files
        from avsec_gym.storage.folder_lock import locked_folder
        from avsec_gym.storage.text_files import read_text
        from avsec_gym.validation.connected.fit import FORMAT
        from avsec_gym.validation.validation_folder import ValidationFolder, usual_folder

        content = read_text(self._constants_file, most=2**28)
        # The name of a default suite's folder has the fingerprint of the world.
        record = {
            "format": FORMAT,
            "version": __version__,
            "data": f"default suite {self._source.root.name}"
            if self.data is None
            else str(self.data.resolve()),
            "method": self.method,
            "poses": self.poses,
            "proposals": self.proposals,
            **self._weights,
            "constants": hashlib.sha256(content.encode()).hexdigest(),
            "alarms": self.alarms,
            "rate": self.rate,
            "attack": self.attack and named_part(self.attack, "--attack"),
            "seed": self.seed,
        }
        if self.method == "learned":
            model = read_text(self._model_file, most=2**28)
            record["model"] = hashlib.sha256(model.encode()).hexdigest()
        if files := named_files(record["attack"]):
            record["files"] = files
        with locked_folder(self.out or usual_folder(_USUAL_OUT, record)) as out:
            yield ValidationFolder(out, record, InstantRow)
