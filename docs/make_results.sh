#!/bin/sh
# Makes the pictures and results that the documentation shows.
# Environment: PYTHON; for the parts on real data KITTI (object root; stereo2012
# and stereo2015 beside it are used too), SCENARIOS, DETECTIONS; for the
# planner's comparison PLANNING (CommonRoad files and primitives) and ORIGINAL (commonroad-search);
# and what docs/make_detector_results.sh takes.
set -eu
cd "$(dirname "$0")/.."
PYTHON=${PYTHON:-python}
"$PYTHON" examples/attack_detections.py --out runs/ghosts > /dev/null
cp runs/ghosts/sheet.png docs/images/demo.png
[ -z "${KITTI:-}" ] || "$PYTHON" -m studies.world.layout_statistics \
    --kitti "$KITTI" --scenarios "$SCENARIOS" --out docs/images
[ -z "${KITTI:-}" ] || "$PYTHON" -m studies.world.evidence \
    --kitti "$KITTI" --out docs/results --images docs/images --json docs/results/world.json
"$PYTHON" benchmarks/world.py > docs/results/world_benchmark.json
[ -z "${DETECTIONS:-}" ] || "$PYTHON" -m studies.driving_safety.report \
    --scenarios "$SCENARIOS" --detections "$DETECTIONS" --out docs/results
"$PYTHON" benchmarks/ghost_places.py ${SCENARIOS:+--scenarios "$SCENARIOS"} > docs/results/ghost_attacker.json
PYTHON="$PYTHON" sh docs/make_detector_results.sh
"$PYTHON" benchmarks/report.py --out docs/results ${SCENARIOS:+--scenarios "$SCENARIOS"} \
    ${PLANNING:+--planning "$PLANNING"} ${ORIGINAL:+--original "$ORIGINAL"}
