"""The training loop on a small task: it learns, stops, and goes on as if it had never stopped."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from torch import Tensor, nn

from avsec_gym.errors import AvsecError, DataError
from avsec_gym.perception.training import training_run
from avsec_gym.perception.training.arithmetic import Choice
from avsec_gym.perception.training.checkpoint import CHECKPOINT
from avsec_gym.perception.training.configuration import Machine, TrainingConfiguration
from avsec_gym.perception.training.curves import CURVES, PICTURE, read_curves
from avsec_gym.perception.training.trainer import TrainingResult, train
from avsec_gym.perception.training.training_run import Compute, HeldOutResult


@dataclass
class Pairs:
    x: Tensor
    y: Tensor

    def to(self, device: torch.device | str) -> Pairs:
        return Pairs(self.x.to(device), self.y.to(device))


class Line:
    """Learn y = 2 x - 1 from noisy samples, by a network with dropout and running statistics."""

    name = "line"
    leading_metric = "precision"
    samples = 14

    def __init__(self, dropout: float = 0.1, stop_after: int | None = None) -> None:
        torch.manual_seed(1)
        self.network: nn.Module = nn.Sequential(
            nn.Linear(1, 8), nn.BatchNorm1d(8), nn.ReLU(), nn.Dropout(dropout), nn.Linear(8, 1)
        )
        self.trained = self.network
        self.steps, self.stop_after = 0, stop_after

    def batch(self, indices: Sequence[int], randomness: np.random.Generator) -> Pairs:
        x = torch.linspace(-1, 1, self.samples)[list(indices), None]
        noise = torch.from_numpy(randomness.normal(0, 0.01, x.shape)).float()
        return Pairs(x, 2 * x - 1 + noise)

    def losses(self, batch: Pairs) -> dict[str, Tensor]:
        if self.steps == self.stop_after:
            raise KeyboardInterrupt
        self.steps += 1
        error = self.network(batch.x) - batch.y
        return {"square": (error**2).mean(), "absolute": 0.1 * error.abs().mean()}

    def validate(self) -> dict[str, float]:
        x = torch.linspace(-1, 1, 51)[:, None]
        error = float((self.network(x) - 2 * x + 1).abs().mean())
        return {"precision": 1 - error, "error": error}

    def description(self) -> dict[str, Any]:
        return {"network": {"layers": 2}}


SIX_STEPS = TrainingConfiguration(epochs=2, batch=4, seed=3, arithmetic="float32")


def weights(folder: Path) -> dict[str, Tensor]:
    state = torch.load(folder / CHECKPOINT, weights_only=True)
    flat = {f"network.{k}": v for k, v in state["trained"].items()}
    flat |= {f"average.{k}": v for k, v in state["average"].items()}
    for number, values in state["optimizer"]["state"].items():
        flat |= {f"optimizer.{number}.{k}": v for k, v in values.items()}
    assert state["step"] == 6
    return flat


@pytest.mark.usefixtures("undrawn_curves")
@pytest.mark.parametrize("stop_after", [1, 3, 4])
def test_interrupted_and_resumed_run_equals_uninterrupted_one_bit_for_bit(
    tmp_path: Path, stop_after: int
) -> None:
    whole, halves = tmp_path / "whole", tmp_path / "halves"
    train(Line(), SIX_STEPS, whole)
    with pytest.raises(KeyboardInterrupt):
        train(Line(stop_after=stop_after), SIX_STEPS, halves)
    torch.manual_seed(99)  # Another process has other random numbers.
    outcome = train(Line(), SIX_STEPS, halves, resume=True, machine=Machine(loaders=2))
    assert outcome.finished
    expected, found = weights(whole), weights(halves)
    assert expected.keys() == found.keys()
    for name in expected:
        assert torch.equal(expected[name], found[name]), name
    assert [row["step"] for row in read_curves(halves)] == [3, 3, 6, 6]
    same = {"seconds"}
    assert [
        {k: v for k, v in row.items() if k not in same}
        for row in read_curves(whole)
        if "metrics" in row
    ] == [
        {k: v for k, v in row.items() if k not in same}
        for row in read_curves(halves)
        if "metrics" in row
    ]


def test_a_run_goes_on_in_the_numbers_that_it_began_with(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen = set()

    class Watched(Line):
        def losses(self, batch: Pairs) -> dict[str, Tensor]:
            seen.add(self.network(batch.x).dtype)
            return super().losses(batch)

    measured = replace(SIX_STEPS, arithmetic="measured")
    for pays in (True, False):
        kind, folder = (torch.bfloat16 if pays else torch.float32), tmp_path / str(pays)
        monkeypatch.setattr(training_run, "choose_arithmetic", lambda *_, pays=pays: Choice(pays))
        with pytest.raises(KeyboardInterrupt):
            train(Watched(stop_after=2), measured, folder)
        monkeypatch.setattr(
            training_run, "choose_arithmetic", lambda *_, pays=pays: Choice(not pays)
        )
        assert train(Watched(), measured, folder, resume=True).finished
        assert seen == {kind}
        seen.clear()


@pytest.mark.usefixtures("undrawn_curves")
def test_a_measured_run_equals_one_that_was_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Measuring leaves no trace, in running statistics neither."""
    monkeypatch.setattr("avsec_gym.perception.training.arithmetic._PAYS", 0.0)
    train(Line(), replace(SIX_STEPS, arithmetic="measured"), tmp_path / "measured")
    train(Line(), SIX_STEPS, tmp_path / "told")
    expected, found = weights(tmp_path / "told"), weights(tmp_path / "measured")
    for name in expected:
        assert torch.equal(expected[name], found[name]), name


@pytest.mark.usefixtures("undrawn_curves")
def test_a_run_that_was_killed_while_it_validated_validates_first(tmp_path: Path) -> None:
    class Killed(Line):
        def validate(self) -> dict[str, float]:
            raise SystemExit  # No checkpoint is written behind it.

    with pytest.raises(SystemExit):
        train(Killed(), SIX_STEPS, tmp_path / "halves")
    task = Line()
    steps: list[int] = []
    validate = task.validate

    def recorded() -> dict[str, float]:
        steps.append(task.steps)
        return validate()

    task.validate = recorded  # type: ignore[method-assign]
    assert train(task, SIX_STEPS, tmp_path / "halves", resume=True).finished
    assert steps == [0, 3]
    train(Line(), SIX_STEPS, tmp_path / "whole")
    for name, value in weights(tmp_path / "whole").items():
        assert torch.equal(value, weights(tmp_path / "halves")[name]), name
    assert [row["step"] for row in read_curves(tmp_path / "halves")] == [3, 3, 6, 6]


@pytest.mark.usefixtures("undrawn_curves")
def test_compute_counts_samples_and_steps_alone(tmp_path: Path) -> None:
    class Slow(Line):
        def losses(self, batch: Pairs) -> dict[str, Tensor]:
            time.sleep(0.02)
            return super().losses(batch)

        def validate(self) -> dict[str, float]:
            time.sleep(0.3)
            return super().validate()

    told: list[Compute] = []
    with pytest.raises(KeyboardInterrupt):
        train(Slow(stop_after=4), SIX_STEPS, tmp_path)
    outcome = train(Slow(), SIX_STEPS, tmp_path, resume=True, on_compute=told.append)
    assert outcome.compute.samples == 24
    assert 0.12 <= outcome.compute.seconds < outcome.seconds - 0.6
    assert outcome.compute.images_per_hour == pytest.approx(3600 * 24 / outcome.compute.seconds)
    assert outcome.compute.arithmetic.startswith("float32")
    assert told[-1].samples == 24


def test_learns_and_keeps_the_best_averaged_weights(tmp_path: Path) -> None:
    kept: list[tuple[int, float]] = []
    told: list[tuple[int, int]] = []
    # All samples in each step: the statistics of half of them are not those of validation, and
    # what came of it was chance (0.85 to 0.92 over six seeds; with all of them 0.96).
    task = Line(dropout=0.0)

    def keep(network: nn.Module, validation: HeldOutResult) -> None:
        assert not network.training
        with torch.no_grad():
            assert task.validate() == validation.metrics
        kept.append((validation.step, validation.metrics["precision"]))

    outcome = train(
        task,
        TrainingConfiguration(
            arithmetic="float32", epochs=240, batch=14, learning_rate=0.03, validate_every=80
        ),
        tmp_path,
        keep=keep,
        on_progress=lambda done, total: told.append((done, total)),
    )
    assert outcome.best is not None
    assert outcome.best > 0.9
    assert outcome.best == kept[-1][1] == max(precision for _, precision in kept)
    assert told[-1] == (240, 240)
    assert (tmp_path / PICTURE).read_bytes().startswith(b"\x89PNG")
    rows = [row for row in read_curves(tmp_path) if "losses" in row]
    assert rows[-1]["losses"]["total"] < 0.3 * rows[0]["losses"]["total"]
    assert rows[0]["rate"] < rows[1]["rate"]
    assert rows[-1]["rate"] < 0.05 * max(row["rate"] for row in rows)


def run_with(task: Line, folder: Path, **changes: Any) -> TrainingResult:
    return train(task, TrainingConfiguration(batch=7, arithmetic="float32", **changes), folder)


@pytest.mark.usefixtures("undrawn_curves")
def test_stops_early_when_nothing_gets_better(tmp_path: Path) -> None:
    task = Line()
    task.validate = lambda: {"precision": 0.5}  # type: ignore[method-assign]
    outcome = run_with(task, tmp_path, epochs=50, patience=3)
    # The first is the best, three more bring nothing.
    assert (outcome.finished, outcome.steps) == (True, 8)


@pytest.mark.usefixtures("undrawn_curves")
def test_a_finished_training_tells_how_it_ended_however_often_it_is_asked(tmp_path: Path) -> None:
    precisions = iter([0.7, 0.2])
    task, again = Line(), Line()
    task.validate = lambda: {"precision": next(precisions)}  # type: ignore[method-assign]
    first = train(task, SIX_STEPS, tmp_path)
    assert first.last is not None
    assert first.best == 0.7
    assert (first.last.step, first.last.epoch, first.last.is_best) == (6, 2, False)
    assert first.last.metrics == {"precision": 0.2}
    second = train(again, SIX_STEPS, tmp_path, resume=True)
    assert second.last == replace(first.last, seconds=second.last.seconds)  # type: ignore[union-attr]
    for name, value in task.network.state_dict().items():
        assert torch.equal(value, again.network.state_dict()[name]), name


@pytest.mark.usefixtures("undrawn_curves")
def test_stops_in_time_and_goes_on(tmp_path: Path) -> None:
    none = train(Line(), SIX_STEPS, tmp_path, machine=Machine(minutes=0.0))
    assert (none.finished, none.steps, none.last) == (False, 0, None)
    assert train(Line(), SIX_STEPS, tmp_path, resume=True).steps == 6
    # What is finished is left as it is.
    assert train(Line(stop_after=0), SIX_STEPS, tmp_path, resume=True).finished


@pytest.mark.usefixtures("undrawn_curves")
def test_refuses_what_would_spoil_a_run(tmp_path: Path) -> None:
    train(Line(), SIX_STEPS, tmp_path)
    with pytest.raises(DataError, match=r"already.*--resume"):
        train(Line(), SIX_STEPS, tmp_path)
    with pytest.raises(DataError, match=r"begun with training.seed 3, this is 4"):
        train(Line(), replace(SIX_STEPS, seed=4), tmp_path, resume=True)
    (tmp_path / CHECKPOINT).write_bytes((tmp_path / CHECKPOINT).read_bytes()[:500])
    with pytest.raises(DataError, match=r"checkpoint.*archive is damaged"):
        train(Line(), SIX_STEPS, tmp_path, resume=True)


@pytest.mark.usefixtures("undrawn_curves")
def test_cut_off_curves_are_repaired(tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt):
        train(Line(stop_after=4), SIX_STEPS, tmp_path)
    with (tmp_path / CURVES).open("a") as file:
        file.write('{"step": 5, "losses": {"square": 1.0}}\n{"step": 6, "los')
    train(Line(), SIX_STEPS, tmp_path, resume=True)
    assert [row["step"] for row in read_curves(tmp_path)] == [3, 3, 6, 6]


@pytest.mark.usefixtures("undrawn_curves")
def test_one_infinite_gradient_is_left_out_and_many_end_the_run(tmp_path: Path) -> None:
    task = Line()
    learn = task.losses

    def once(batch: Pairs) -> dict[str, Tensor]:
        return {k: v * (math.inf if task.steps == 2 else 1) for k, v in learn(batch).items()}

    task.losses = once  # type: ignore[method-assign]
    assert run_with(task, tmp_path / "once", epochs=3).finished
    assert all(torch.isfinite(value).all() for value in task.network.state_dict().values())

    def always(batch: Pairs) -> dict[str, Tensor]:
        return {name: value * math.nan for name, value in learn(batch).items()}

    task.losses = always  # type: ignore[method-assign]
    with pytest.raises(AvsecError, match=r"no finite gradient in 20 steps"):
        run_with(task, tmp_path / "always", epochs=30)
