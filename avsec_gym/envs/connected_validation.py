"""`avsec/ConnectedValidation-v0`: a base station that names the vehicle which is lied to."""

from __future__ import annotations

from dataclasses import is_dataclass, replace
from functools import cached_property
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from avsec_gym.argument_checks import number, shown, whole_number
from avsec_gym.envs.actions import checked_flags
from avsec_gym.envs.connected_instants import (
    REFUSED,
    SUITE,
    NamedInstants,
    PlayedInstants,
    vehicles_of,
    without_an_episode,
)
from avsec_gym.envs.parts import parts_of, takes_parts
from avsec_gym.envs.rendering import DrawnEnv
from avsec_gym.envs.reset_options import reset_options
from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats
from avsec_gym.registry import Kind, make
from avsec_gym.scenario.intention import Intention, intentions_named
from avsec_gym.validation.connected.attacks.attacked_instant import AttackedInstant, InstantAttack
from avsec_gym.validation.connected.fit import SHIPPED_FIT, read_connected_fit
from avsec_gym.validation.connected.proposals.remembered import RememberedProposals
from avsec_gym.validation.connected.rays.rates import log_likelihood_ratio
from avsec_gym.validation.connected.recordings import RecordedInstant
from avsec_gym.validation.connected.result import ConnectedResult
from avsec_gym.validation.connected.validator import ConnectedValidator

Observation = NDArray[np.float32]
REGIONS = 3
_LARGEST = 10.0
"""Log-likelihood ratios are cut to this size."""
_ATTACKS = ("paste", "removal")


@takes_parts(
    Kind.VALIDATOR,
    refused=REFUSED | {"validator": "the agent plays it"},
    scenarios=SUITE,
)
class ConnectedValidationEnv(DrawnEnv[Observation]):
    """Name the vehicle whose LiDAR is attacked, from the rays of all vehicles.

    **Naming no vehicle wins half of the episodes.**  By default 50 % of them have no attack
    (`unattacked=0.5`), and there this constant answer is right; it is right in no other.  A base
    station is to be held against that figure; `unattacked=0` leaves the constant nothing.

    ## Description
    Several vehicles with LiDARs see one place.  At some instants an attacker pastes the scan of a
    real object into one vehicle's scan, or removes an object from it (thesis, chapter 4).  Vehicles
    send where their rays end in regions in which objects may be, and how many of their rays support
    the claims of the others.  The agent is the base station that decides.

    ## Observation
    `Box(-1, 1, (4 V (V - 1) + 3,), float32)` for V vehicles.  A pair is a claimer j and a witness
    k, in the order (0, 1), (0, 2), ..., (1, 0), ...; evidence is the log-likelihood ratio of what k
    counts of a claim of j for nothing being there, cut to 10 and divided by it, 0 where k's rays
    decide nothing.  First the evidence of all pairs in the three regions with the most of it by any
    one pair, region by region; then of each pair the share of all regions that k decides on; then
    of these three regions the score of `avsec_gym.validation.connected.rays.decision.decide` (cut
    to 20 and divided by it).  For three vehicles 27 numbers.

    ## Action
    `MultiBinary(V)`: for each vehicle, whether its LiDAR is attacked.

    ## Reward
    1 if exactly the attacked vehicle is named, none where none is attacked; else 0.

    ## Episode end
    Terminated after one step.

    ## Info
    `is_success` (named exactly), `attacked` and `named` (vehicles, such as `"0 2"`; empty at reset,
    and where there are none), `kind` (`ghost`, `removal`, or empty), `regions` (compared),
    `decidable` (two vehicles decide on it), `station` (vehicles that `ConnectedValidator` names by
    the shipped fit), `station_alarm`.  As in every environment, `planned`, `success`, `collision`,
    `safe`, `cost`, `path_length`, `smallest_distance`, `cost_sm1`, `outcome`, `scenario` (the
    instant's id), `intention`: no car drives, so that the numbers are 0 and the outcome is
    `unplanned`.

    ## Arguments
    * `scenarios="connected"`: the default suite, made in the cache on first use; a folder of
      `avsec world make --suite connected`; a dictionary such as `{"source": "data/connected",
      "first": 0, "count": 20}`, to train and to judge on different ones.
    * `attacks=("paste", "removal")`: names or dictionaries of
      `avsec_gym.registry.Kind.CONNECTED_ATTACK`; each is as likely.
    * `unattacked=0.5`: share of the episodes without an attack.
    * `variants=4`: so many different attacks of a kind on a vehicle at an instant.
    * `render_mode`: None, `"rgb_array"` or `"human"` (needs the extra `view`).

    `reset(options={"scenario": id, "attacked": [1]})` picks an instant, and a victim; `[]` is none.

    ## Versions
    * v0: first.
    """

    title = "avsec/ConnectedValidation-v0"

    def __init__(
        self,
        *,
        attacks: tuple[Any, ...] = _ATTACKS,
        unattacked: float = 0.5,
        variants: int = 4,
        render_mode: str | None = None,
        **parts: Any,
    ) -> None:
        super().__init__(render_mode)
        self.parts = parts_of(self, parts)
        self._scenarios = NamedInstants(self.parts.scenarios)
        self._attacks = _made(attacks)
        self.unattacked = number("unattacked", unattacked, 0.0, 1.0)
        self.variants = whole_number("variants", variants, 1, 1_000_000)
        vehicles = vehicles_of(self._scenarios)
        self.vehicles = vehicles
        size = (REGIONS + 1) * vehicles * (vehicles - 1) + REGIONS
        self.observation_space = gym.spaces.Box(-1.0, 1.0, (size,), np.float32)
        self.action_space = gym.spaces.MultiBinary(vehicles)  # type: ignore[assignment]
        self._id, self._intention = "", Intention.STRAIGHT
        self._instant: RecordedInstant | None = None
        self._attacked: AttackedInstant | None = None
        self._result: ConnectedResult | None = None
        self._named: NDArray[np.bool_] | None = None

    @cached_property
    def instants(self) -> PlayedInstants:
        """The instants that are played, without an attack."""
        return PlayedInstants(self._scenarios)

    @cached_property
    def station(self) -> ConnectedValidator:
        """The vehicles and the base station whose evidence the agent sees."""
        constants = read_connected_fit(SHIPPED_FIT).constants()
        return ConnectedValidator(constants, "rays", RememberedProposals())

    @property
    def result(self) -> ConnectedResult:
        """What the station makes of the instant, for agents that need all of it.

        Raises:
            ResetNeeded: There is no instant yet.
        """
        if self._result is None:
            raise gym.error.ResetNeeded("call reset before step")
        return self._result

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Draw an instant and an attack; ``options`` may pick them, and an ``intention``."""
        super().reset(seed=seed)
        options = reset_options(options, "attacked")
        random, ids = self.np_random, self.instants.ids
        intentions = intentions_named(options.get("intention"))
        self._intention = intentions[int(random.integers(len(intentions)))]
        drawn = ids[int(random.integers(len(ids)))]
        picked = options.get("scenario")
        self._id = drawn if picked is None else self.instants.named(picked)
        victim, kind = int(random.integers(self.vehicles)), int(random.integers(len(self._attacks)))
        variant = int(random.integers(self.variants))
        is_attacked = random.random() >= self.unattacked
        if "attacked" in options:
            chosen = self._chosen(options["attacked"])
            is_attacked, victim = bool(chosen), chosen[0] if chosen else victim
        recorded = self.instants.instant(self._id)
        self._attacked = None
        if is_attacked:
            self._attacked = _on(self._attacks[kind], recorded, victim, variant)
        self._instant = recorded if self._attacked is None else self._attacked.instant
        self._result = self.station.validate(self._instant.scans, id=self._id)
        self._named = None
        self.shown()
        return self._observe(), self._info()

    def step(self, action: NDArray[Any]) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Compare with who was attacked; the episode is over."""
        _ = self.result
        self._named = checked_flags(action, self.vehicles)
        self.shown()
        info = self._info()
        return self._observe(), float(info["is_success"]), True, False, info

    def picture(self) -> NDArray[np.uint8] | None:
        """All scans from above, and the regions that alarm by the station's own rule."""
        if self._result is None or self._instant is None:
            return None
        from avsec_gym.drawing.connected_picture import draw_connected
        from avsec_gym.drawing.scenario_picture import picture_array

        return picture_array(draw_connected(self._result, self._instant.scans))

    def _chosen(self, attacked: Any) -> list[int]:
        """The vehicle that a user wants attacked."""
        known = range(self.vehicles)
        whole = isinstance(attacked, list | tuple) and all(
            type(each) is int and each in known for each in attacked
        )
        if not whole or len(attacked) > 1:
            raise ConfigurationError(
                f"attacked is a list of one vehicle from 0 to {self.vehicles - 1}, or [], got "
                f"{shown(attacked)}"
            )
        return list(attacked)

    def _observe(self) -> Observation:
        return evidence_features(self.result, self.station).astype(np.float32)

    def _info(self) -> dict[str, Any]:
        over, result = self._named is not None, self.result
        attacked = np.zeros(self.vehicles, bool)
        if over and self._attacked is not None:
            attacked[self._attacked.victim] = True
        named = np.zeros(self.vehicles, bool) if self._named is None else self._named
        return {
            **without_an_episode(self._id, str(self._intention), over=over),
            "is_success": over and bool((named == attacked).all()),
            "attacked": _listed(attacked),
            "named": _listed(named),
            "kind": self._attacked.kind if over and self._attacked is not None else "",
            "regions": len(result.regions),
            "decidable": int(result.decidable.sum()),
            "station": " ".join(map(str, result.accused)),
            "station_alarm": result.alarm,
        }


def evidence_features(result: ConnectedResult, station: ConnectedValidator) -> Floats:
    """What the agent sees of an instant, see `ConnectedValidationEnv`.

    Args:
        result: The decision of the method of rays.
        station: What decided; its chances of rays weigh the counts.
    """
    assert result.counts is not None
    vehicles = result.counts.shape[1]
    pairs = ~np.eye(vehicles, dtype=bool)
    evidence = log_likelihood_ratio(result.counts, station.constants.rates)[:, pairs]
    evidence = np.clip(evidence / _LARGEST, -1.0, 1.0)
    witnessed = np.asarray(result.counts.any(axis=3))[:, pairs]
    first = np.argsort(-evidence.max(axis=1, initial=-1.0), kind="stable")[:REGIONS]
    most, score = np.zeros((REGIONS, pairs.sum())), np.zeros(REGIONS)
    most[: len(first)] = evidence[first]
    score[: len(first)] = np.clip(result.score[first] / (2 * _LARGEST), -1.0, 1.0)
    share = witnessed.mean(axis=0) if len(witnessed) else np.zeros(pairs.sum())
    return np.concatenate([most.ravel(), share, score])


def _made(attacks: Any) -> tuple[InstantAttack, ...]:
    if not isinstance(attacks, list | tuple) or not attacks:
        raise ConfigurationError(
            f"attacks are names, such as {list(_ATTACKS)}, one or more, got {shown(attacks)}"
        )
    return tuple(make(Kind.CONNECTED_ATTACK, each) for each in attacks)


def _on(
    attack: InstantAttack, instant: RecordedInstant, victim: int, variant: int
) -> AttackedInstant | None:
    """An attack on a vehicle that was drawn; an attack that names its vehicle keeps to it."""
    if is_dataclass(attack) and getattr(attack, "vehicle", 0) is None:
        attack = replace(attack, vehicle=victim)
    return attack.attack(instant, (victim, variant))


def _listed(flags: NDArray[np.bool_]) -> str:
    return " ".join(str(vehicle) for vehicle in np.flatnonzero(flags))
