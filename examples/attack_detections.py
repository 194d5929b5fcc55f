"""What can two ghost objects do?  Puts them into the true detections of procedural scenes.

    python examples/attack_detections.py [--scenes 200] [--seed 0] [--out runs/ghosts]

No images, no network: seconds.  Prints the rates by intention without and with the attack as JSON;
`--out` is a folder for pictures of a street and of a highway, whose own files there are replaced.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from avsec_gym.drawing.scenario_picture import draw_episode, draw_sheet, save_picture
from avsec_gym.evaluation.files import episode_with_tree
from avsec_gym.evaluation.ghost_attack import AttackedEpisode, ghost_attack, summary
from avsec_gym.scenario.scene import Motion
from avsec_gym.scenario.scene_sets import procedural_scenes


def draw(episodes: list[AttackedEpisode], folder: Path) -> None:
    """A street and a highway that the attack makes unsafe, as they are and attacked; a sheet."""
    turned = [each for each in episodes if each.clean.safe and not each.attacked.safe]
    # Where much goes on, there is more to see.
    turned.sort(key=lambda each: -len(each.scene.boxes))
    chosen = []
    for road_type in ("street", "highway"):
        chosen += [each for each in turned if each.scene.road_type == road_type][:1]
    folder.mkdir(parents=True, exist_ok=True)
    shown = []
    for each in chosen or episodes[:1]:
        for name, believed in (("clean", None), ("attacked", each.believed)):
            episode = episode_with_tree(each.scene, each.intention, believed, Motion.TRUTH)
            shown.append(episode)
            path = folder / f"{each.scene.road_type}_{name}.png"
            save_picture(draw_episode(episode), path, overwrite=True)
    save_picture(draw_sheet(shown), folder / "sheet.png", overwrite=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenes", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path)
    options = parser.parse_args()
    episodes = ghost_attack(procedural_scenes(options.scenes, seed=options.seed))
    json.dump(summary(episodes), sys.stdout, indent=1)
    sys.stdout.write("\n")
    if options.out is not None:
        draw(episodes, options.out)


if __name__ == "__main__":
    main()
