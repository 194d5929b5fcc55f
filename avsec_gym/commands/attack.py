"""`avsec attack patch`: trains a patch, in as many sittings as it takes."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from avsec_gym import console
from avsec_gym.argument_checks import thread_number, whole_number
from avsec_gym.attacks.patch_configuration import PatchTraining


@dataclass(frozen=True)
class AttackPatch:
    """Train a patch that makes detectors see a car where none is.

    In --out: patch.safetensors with a picture and a card, the checkpoint, and the curves of the
    loss to the ghosts.
    """

    detector: tuple[str, ...]
    """Name, such as dsgn, or JSON with arguments, '{"name": "dsgn", "weights": "my.st"}'; several
    make one patch against all of them."""
    kitti: Path
    """A folder in KITTI's object layout, such as `avsec world make` writes."""
    out: Path
    """Folder of the training."""
    split: str = "train"
    """The frames of ImageSets/SPLIT.txt; `all`: every frame."""
    limit: int | None = None
    """Only the first frames."""
    resume: bool = False
    """Go on with the training in --out, or begin it."""
    threads: int | None = None
    """Threads of the processor. Default: torch's choice."""
    training: PatchTraining = field(default_factory=PatchTraining)
    """What the result depends on."""
    json: bool = False
    """Print a summary as JSON."""

    def run(self) -> int:
        """Do it; the exit code."""
        import torch

        from avsec_gym.attacks.patch_scenes import KittiScenes
        from avsec_gym.attacks.patch_training import PATCH, train_patch
        from avsec_gym.commands.named_part import named_part
        from avsec_gym.kitti.dataset import KittiObject
        from avsec_gym.registry import check, make

        if self.limit is not None:
            whole_number("--limit", self.limit, 1)
        if self.threads is not None:
            torch.set_num_threads(thread_number("--threads", self.threads))
        named = [named_part(text) for text in self.detector]
        for part in named:
            check("detector", part)  # A slip is reported before any frame is looked for.
        scenes = KittiScenes.of_split(
            KittiObject(self.kitti), None if self.split == "all" else self.split, self.limit
        )
        detectors = [make("detector", part) for part in named]
        with console.progress("training the patch") as shown:
            patch = train_patch(
                detectors,
                scenes,
                self.training,
                self.out,
                resume=self.resume,
                on_progress=shown,
                on_epoch=_tell,
            )
        assert patch.card is not None, "a trained patch has a card"
        if self.json:
            console.print_json(
                "attack.patch",
                {
                    "patch": str(self.out / PATCH),
                    "sha256": patch.card.sha256,
                    "frames": len(scenes),
                    "epochs": patch.card.epochs,
                    "steps": patch.card.steps,
                    "minutes": patch.card.minutes,
                    "losses": patch.card.losses,
                },
            )
        else:
            grey, trained = patch.card.losses["grey"], patch.card.losses["patch"]
            means = ", ".join(f"{name} {grey[name]:.3f} to {trained[name]:.3f}" for name in grey)
            console.say(f"{self.out / PATCH}: mean loss to the ghosts, from plain grey: {means}")
        return console.DONE


def _tell(epoch: int, losses: dict[str, float]) -> None:
    means = ", ".join(f"{name} {loss:.3f}" for name, loss in losses.items())
    console.say(f"epoch {epoch}: mean loss to the ghosts: {means}")
