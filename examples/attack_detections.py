"""What can two ghost objects do?  Puts them into the true detections of procedural scenes.

python examples/attack_detections.py [--scenes 200] [--seed 0] [--out runs/ghosts]

Prints rates without and with the attack as JSON, in seconds; `--out` is a folder for pictures.
"""

import argparse
import json
from pathlib import Path

from avsec_gym.drawing.scenario_picture import draw_episode, draw_sheet, save_picture
from avsec_gym.evaluation.files import episode_with_tree
from avsec_gym.evaluation.ghost_attack import ghost_attack, summary
from avsec_gym.scenario.scene import Motion
from avsec_gym.scenario.scene_sets import procedural_scenes

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--scenes", type=int, default=200)
parser.add_argument("--seed", type=int, default=0)
parser.add_argument("--out", type=Path, help="files of this name in it are replaced")
given = parser.parse_args()
episodes = ghost_attack(procedural_scenes(given.scenes, seed=given.seed))
print(json.dumps(summary(episodes), indent=1))
if given.out is not None:
    unsafe = [each for each in episodes if each.clean.safe and not each.attacked.safe] or episodes
    # A street and a highway, without and with the attack; where much goes on, there is more to see.
    by_road, shown = {}, []
    for each in sorted(unsafe, key=lambda each: -len(each.scene.boxes)):
        by_road.setdefault(each.scene.road_type, each)
    for road, each in sorted(by_road.items(), reverse=True):
        for name, believed in (("clean", None), ("attacked", each.believed)):
            shown.append(episode_with_tree(each.scene, each.intention, believed, Motion.TRUTH))
            picture = given.out / f"{road}_{name}.png"
            save_picture(draw_episode(shown[-1]), picture, overwrite=True)
    save_picture(draw_sheet(shown), given.out / "sheet.png", overwrite=True)
