#!/bin/sh
# Makes studies/results/chapter5.md: the thesis' central experiment on digital twins of the authors' 600
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
avsec report "$RUNS/chapter5" --markdown studies/results/chapter5.md --overwrite --json \
    > "$RUNS/chapter5.json"
placeless "$RUNS/chapter5.json" > studies/results/chapter5.json
placeless "$RUNS/chapter5/manifest.json" > studies/results/chapter5_manifest.json
"$PYTHON" -m studies.chapter5.score_thresholds "$RUNS/chapter5" \
    --markdown studies/results/chapter5_thresholds.md --json studies/results/chapter5_thresholds.json
"$PYTHON" -m studies.chapter5.costly_errors "$RUNS/chapter5" \
    --markdown studies/results/chapter5_errors.md --json studies/results/chapter5_errors.json
"$PYTHON" -m studies.chapter5.decoupling_figure studies/results/chapter5.json \
    studies/results/chapter5_errors.json --figure docs/images/chapter5.png

# All 600 with nobody attacking: the U columns, and how long one setting takes.
avsec run unattacked --scenarios "$SCENARIOS" --options "$FRAMES" sanity_sheet=false --threads 1 \
    --out "$RUNS/unattacked"
avsec report "$RUNS/unattacked" --pictures 0 --markdown studies/results/chapter5_unattacked.md --overwrite

# Stereo R-CNN whose scores tell the class alone, as published, instead of the images' agreement too;
# calibrated on the frames that the package's own was (docs/detectors.md, "Training").
PLAIN=$RUNS/without_evidence
avsec world make --suite mixed --frames 200 --seed 3 --no-lidar --out "$RUNS/train/validation"
[ -d "$PLAIN" ] || {
    rm -rf "$PLAIN.part"
    mkdir "$PLAIN.part"
    cp avsec_gym/perception/weights/stereo_rcnn_small.* "$PLAIN.part"
    avsec weights calibrate "$PLAIN.part/stereo_rcnn_small.safetensors" \
        --kitti "$RUNS/train/validation" --no-evidence
    mv "$PLAIN.part" "$PLAIN"
}
avsec run patch --scenarios "$SCENARIOS" --limit "${LIMIT:-200}" --threads 1 \
    --options "$FRAMES" sanity_sheet=false "stereo_rcnn=$PLAIN/stereo_rcnn_small.safetensors" \
    --out "$RUNS/chapter5_without_evidence"
avsec report "$RUNS/chapter5_without_evidence" --pictures 0 \
    --markdown studies/results/chapter5_without_evidence.md --overwrite

# DSGN without its spatial pyramid pooling: the package's weights go on learning without it, and a
# patch is trained against them as the package's were.
WITHOUT=$RUNS/dsgn_without_pyramid
avsec world make --suite mixed --frames 500 --seed 1 --no-lidar --out "$RUNS/train/world"
[ -f "$WITHOUT/weights.safetensors" ] || {
    avsec train dsgn --preset small_without_pyramid \
        --start avsec_gym/perception/weights/dsgn_small.safetensors --data "$RUNS/train/world" \
        --out "$WITHOUT.part" --batch 2 --threads 1 --epochs 3 --learning-rate 5e-4 --keep last --resume
    avsec weights calibrate "$WITHOUT.part/weights.safetensors" --kitti "$RUNS/train/validation"
    mv "$WITHOUT.part" "$WITHOUT"
}
VICTIM='{"name": "dsgn", "configuration": "small_without_pyramid", "weights": "'$WITHOUT'/weights.safetensors"}'
avsec attack patch --detector "$VICTIM" --kitti "$RUNS/train/world" --limit 80 --epochs 6 --threads 1 \
    --out "$RUNS/patch_without_pyramid" --resume
mkdir -p "$RUNS/patches"
cp avsec_gym/attacks/patches/* "$RUNS/patches"
cp "$RUNS/patch_without_pyramid/patch.safetensors" "$RUNS/patches/dsgn_without_pyramid.safetensors"
avsec run without_pyramid --scenarios "$SCENARIOS" --limit "${LIMIT:-200}" --threads 1 \
    --options "$FRAMES" sanity_sheet=false "patches=$RUNS/patches" \
    "dsgn_without_pyramid=$WITHOUT/weights.safetensors" --out "$RUNS/without_pyramid"
avsec report "$RUNS/without_pyramid" --pictures 0 \
    --markdown studies/results/chapter5_without_pyramid.md --overwrite
