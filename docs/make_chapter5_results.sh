#!/bin/sh
# Makes docs/results/chapter5.md: the thesis' central experiment on digital twins of the authors' 600
# scenarios, with the small detectors and the patches of the package.  Hours; every step goes on
# where it was stopped.  Environment: PYTHON; KITTI (object root, whose labels and calibrations the
# twins are made of); SCENARIOS, the authors' labelled scenarios; RUNS, where twins and runs lie;
# LIMIT, of the scenarios: 600 take eight core-hours, the page in the repository is of 200.
set -eu
: "${KITTI:?the root of KITTI object data}" "${SCENARIOS:?the folder of the labelled scenarios}"
cd "$(dirname "$0")/.."
PYTHON=${PYTHON:-python}
RUNS=${RUNS:-runs}
avsec() { "$PYTHON" -m avsec_gym "$@"; }
placeless() { sed -e "s|$PWD/||g" -e "s|$SCENARIOS|SCENARIOS|g" "$1"; }  # No paths of one machine.
ids() { for part; do ls "$SCENARIOS/$part"; done | sed 's/\.txt$//' | sort; }
# shellcheck disable=SC2046  # A word for each id.
avsec world twin --kitti "$KITTI" --ids $(ids road_dynamic_label) --road-type highway --no-lidar \
    --out "$RUNS/twins/highway"
# shellcheck disable=SC2046
avsec world twin --kitti "$KITTI" --ids $(ids dynamic_label static_label nocar) --road-type street \
    --no-lidar --out "$RUNS/twins/street"
FRAMES=frames=$RUNS/twins/street,$RUNS/twins/highway
avsec run chapter5 --scenarios "$SCENARIOS" --limit "${LIMIT:-200}" --options "$FRAMES" --threads 1 \
    --out "$RUNS/chapter5"
avsec report "$RUNS/chapter5" --markdown docs/results/chapter5.md --overwrite --json \
    > "$RUNS/chapter5.json"
placeless "$RUNS/chapter5.json" > docs/results/chapter5.json
placeless "$RUNS/chapter5/manifest.json" > docs/results/chapter5_manifest.json
"$PYTHON" -m avsec_gym.experiments.chapter5.score_thresholds "$RUNS/chapter5" \
    --markdown docs/results/chapter5_thresholds.md --json docs/results/chapter5_thresholds.json
"$PYTHON" -m avsec_gym.experiments.chapter5.costly_errors "$RUNS/chapter5" \
    --markdown docs/results/chapter5_errors.md --json docs/results/chapter5_errors.json

# All 600 with nobody attacking: the U columns, and how long one setting takes.
avsec run unattacked --scenarios "$SCENARIOS" --options "$FRAMES" sanity_sheet=false --threads 1 \
    --out "$RUNS/unattacked"
avsec report "$RUNS/unattacked" --pictures 0 --markdown docs/results/chapter5_unattacked.md --overwrite

# Stereo R-CNN whose scores tell the class alone, as published, instead of the images' agreement too;
# calibrated on the frames that the package's own was (docs/detectors.md, "Training").
PLAIN=$RUNS/without_evidence
[ -d "$PLAIN" ] || {
    avsec world make --suite mixed --frames 200 --seed 3 --no-lidar --out "$RUNS/train/validation"
    rm -rf "$PLAIN.part"
    mkdir "$PLAIN.part"
    cp avsec_gym/perception/weights/stereo_rcnn_small.* "$PLAIN.part"
    avsec weights calibrate "$PLAIN.part/stereo_rcnn_small.safetensors" \
        --kitti "$RUNS/train/validation" --no-evidence
    mv "$PLAIN.part" "$PLAIN"
}
avsec run patch --scenarios "$SCENARIOS" --limit "${LIMIT:-200}" --threads 1 \
    --options "$FRAMES" "stereo_rcnn=$PLAIN/stereo_rcnn_small.safetensors" \
    --out "$RUNS/chapter5_without_evidence"
avsec report "$RUNS/chapter5_without_evidence" --pictures 0 \
    --markdown docs/results/chapter5_without_evidence.md --overwrite
