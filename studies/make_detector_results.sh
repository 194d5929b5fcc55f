#!/bin/sh
# Makes studies/results/detectors.md with its numbers and pictures, from the weights in the package.
# Environment: PYTHON; HELD_OUT, where the frames lie on which the detectors are judged (made if they
# are not there); SCANS, the same with scans, for the detectors of one sensor; KITTI (object root;
# stereo2012 and stereo2015 beside it are used too) for real frames; RUNS, where `avsec train` left the
# folders dsgn, stereo_rcnn, psmnet, pixor, pointrcnn, faster_rcnn and yolo, and dsgn_2, ... of trainings
# that went on with them, for the curves (those of other networks stay as they are); CLASSIFIERS, the
# folders of held-out moments of docs/classifiers.md; SCENARIOS, the authors' labelled scenarios; PARITY
# (outputs of the original networks).
set -eu
cd "$(dirname "$0")/.."
PYTHON=${PYTHON:-python}
HELD_OUT=${HELD_OUT:-runs/held_out}
SCANS=${SCANS:-runs/lidar/held_out}
RUNS=${RUNS:-runs}
"$PYTHON" -m avsec_gym world verify "$HELD_OUT" > /dev/null 2>&1 || "$PYTHON" -m avsec_gym \
    world make --suite mixed --frames 240 --seed 2 --no-lidar --out "$HELD_OUT"
"$PYTHON" -m studies.perception.detector_precision --kitti "$HELD_OUT" \
    --figures studies/results/images --json studies/results/detectors.json
"$PYTHON" -m studies.perception.disparity_accuracy --world "$HELD_OUT" \
    ${KITTI:+--kitti "$KITTI"} --json studies/results/disparity.json
[ -z "${KITTI:-}" ] || "$PYTHON" -m studies.perception.real_frames --kitti "$KITTI" \
    --precision studies/results/detectors.json --figure studies/results/images/real_frames.png \
    --json studies/results/real_frames.json
"$PYTHON" -m avsec_gym world verify "$SCANS" > /dev/null 2>&1 || "$PYTHON" -m avsec_gym \
    world make --suite mixed --frames 200 --seed 2 --out "$SCANS"
"$PYTHON" -m studies.perception.single_sensor_precision --kitti "$SCANS" \
    ${KITTI:+--real "$KITTI"} --json studies/results/single_sensor_detectors.json
set --
for name in dsgn stereo_rcnn psmnet pixor pointrcnn faster_rcnn yolo; do
    folders=
    for folder in "$RUNS/$name" "$RUNS/${name}_2"; do
        [ ! -f "$folder/curves.jsonl" ] || folders="$folders${folders:+,}$folder"
    done
    [ -z "$folders" ] || set -- "$@" "$name=$folders"
done
[ $# -eq 0 ] || "$PYTHON" -m studies.perception.training_curves "$@" \
    --others studies/results/detector_training.json --figure studies/results/images/detector_training.png \
    --json studies/results/detector_training.json
[ -z "${CLASSIFIERS:-}" ] || "$PYTHON" -m studies.perception.classifier_accuracy \
    --world $CLASSIFIERS ${KITTI:+--kitti "$KITTI"} ${SCENARIOS:+--scenarios "$SCENARIOS"} \
    --json studies/results/classifiers.json
"$PYTHON" benchmarks/detectors.py > studies/results/detector_benchmark.json
"$PYTHON" examples/rank_detectors.py > studies/results/detector_ranking.json
[ -z "${PARITY:-}" ] || "$PYTHON" -m benchmarks.parity "$PARITY" --json > studies/results/parity.json
"$PYTHON" -m studies.perception.page --results studies/results > /dev/null
