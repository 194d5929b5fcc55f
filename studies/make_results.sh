#!/bin/sh
# Makes the pictures and results that the documentation shows.
# Environment: PYTHON; for the parts on real data KITTI (object root; stereo2012
# and stereo2015 beside it are used too), SCENARIOS, DETECTIONS; for the
# planner's comparison PLANNING (CommonRoad files and primitives) and ORIGINAL (commonroad-search);
# and what studies/make_detector_results.sh takes.
set -eu
cd "$(dirname "$0")/.."
PYTHON=${PYTHON:-python}
"$PYTHON" examples/attack_detections.py --out runs/ghosts > /dev/null
cp runs/ghosts/sheet.png docs/images/demo.png
[ -z "${KITTI:-}" ] || "$PYTHON" -m studies.world.layout_statistics \
    --kitti "$KITTI" --scenarios "$SCENARIOS" --out docs/images
[ -z "${KITTI:-}" ] || "$PYTHON" -m studies.world.evidence \
    --kitti "$KITTI" --out studies/results --images studies/results/images --json studies/results/world.json
"$PYTHON" benchmarks/world.py > studies/results/world_benchmark.json
[ -z "${DETECTIONS:-}" ] || "$PYTHON" -m studies.driving_safety.report \
    --scenarios "$SCENARIOS" --detections "$DETECTIONS" --out studies/results
"$PYTHON" benchmarks/ghost_places.py ${SCENARIOS:+--scenarios "$SCENARIOS"} > studies/results/ghost_attacker.json
PYTHON="$PYTHON" sh studies/make_detector_results.sh
"$PYTHON" benchmarks/report.py --out studies/results ${SCENARIOS:+--scenarios "$SCENARIOS"} \
    ${PLANNING:+--planning "$PLANNING"} ${ORIGINAL:+--original "$ORIGINAL"}
