#!/bin/sh
# Makes the pages of chapter 3 in studies/results: are attacks on LiDAR and cameras noticed, and are the
# attacked sensors named; what do attackers gain who know how; what do attacks cost detectors, and what
# do objects tell of them; is the damage found and repaired; what is a defence worth; and what does it
# cost an attacker to stay unnoticed?  Hours; every run goes on where it was stopped.  Judged are drives
# of seed 2, which nobody saw while the method was made, by what was fitted on those of seed 0; but how
# far scans are refilled was chosen, on drives of seed 0, after a look at what `localisation` told of them.
# Environment: PYTHON; RUNS, where runs lie; LIMIT, moments of each part, which are rendered once into
# the cache; SHIPPED and SHIPPED_JUDGED, frames that what the package ships is fitted and judged on;
# KITTI, the root of the object benchmark, whose frames with both images and a scan are
# attacked, too.
set -eu
cd "$(dirname "$0")/.."
PYTHON=${PYTHON:-python}
RUNS=${RUNS:-runs}
LIMIT=${LIMIT:-1000}
SHIPPED=${SHIPPED:-160}
SHIPPED_JUDGED=${SHIPPED_JUDGED:-52}
# 3: all but some moments, which the page tells.
avsec() { "$PYTHON" -m avsec_gym "$@" || [ $? -eq 3 ]; }
run() {  # NAME of a run in RUNS, then experiments and options
    NAME=$1
    shift
    avsec run "$@" --seed 2 --threads 1 --retry --out "$RUNS/$NAME"
}
page() {  # NAME of a run in RUNS and of its page
    avsec report "$RUNS/$1" --markdown "studies/results/$1.md" --overwrite --json > "$RUNS/$1.json"
    sed "s|$PWD/||g" "$RUNS/$1.json" > "studies/results/$1.json"
}
run identification_sgbm identification knowing --limit "$LIMIT" --options fit_seed=0
page identification_sgbm
run identification_psmnet identification --limit "$LIMIT" --options fit_seed=0 depth=psmnet
page identification_psmnet
run five_sensors five_sensors --limit 300 --options fit_seed=0
page five_sensors
"$PYTHON" -m studies.chapter3.identification_figure \
    studies/results/identification_sgbm.json --out docs/images/identification.png
"$PYTHON" -m studies.chapter3.optical_attacks_figure --out docs/images
"$PYTHON" -m studies.chapter3.detection_scheme_figure --out docs/images
run optical_attacks object_level impact sensitivity --limit "$LIMIT" --options fit_seed=0
page optical_attacks
run believed believed --limit 300 --options fit_seed=0
page believed
run localisation localisation --limit 300 --options detector=stereo_rcnn scan_detector=pointrcnn
page localisation
run defence defence --limit 600 --options fit_seed=0 "fit_limit=$LIMIT"
page defence
run defence_stereo_rcnn defence --limit 120 --options fit_seed=0 "fit_limit=$LIMIT" detectors=stereo_rcnn
page defence_stereo_rcnn
"$PYTHON" -m studies.chapter3.other_pairs --seed 2 --json studies/results/other_pairs.json
[ -z "${KITTI:-}" ] || "$PYTHON" -m studies.chapter3.real_frames --kitti "$KITTI" \
    --json studies/results/identification_real.json
"$PYTHON" -m studies.chapter3.real_frames_page studies/results/identification_real.json \
    --out studies/results/identification_real.md
# The package's own thresholds and likelihoods; whoever makes them anew judges them anew.
"$PYTHON" -m studies.chapter3.shipped_fits.fit --frames "$SHIPPED" \
    --samples "$RUNS/shipped_fits/samples.jsonl"
"$PYTHON" -m studies.chapter3.shipped_fits.judge --frames "$SHIPPED_JUDGED" \
    ${KITTI:+--kitti "$KITTI"} --samples "$RUNS/shipped_fits/judged.jsonl" \
    --json studies/results/shipped_fits.json
"$PYTHON" -m studies.chapter3.shipped_fits.page studies/results/shipped_fits.json \
    --out studies/results/shipped_fits.md
rm -rf "$RUNS/alarm"
avsec validate --clean 0.25 --attack '{"name": "facula", "camera": 3}' --out "$RUNS/alarm" > /dev/null
"$PYTHON" -c 'import cv2, sys; cv2.imwrite(sys.argv[2], cv2.imread(sys.argv[1]))' \
    "$RUNS/alarm/alarms/2026_01_01_drive_0002_sync_0000000015.png" docs/images/alarm.jpg
"$PYTHON" benchmarks/validation.py > "$RUNS/validation_benchmark.json"
cp "$RUNS/validation_benchmark.json" studies/results
"$PYTHON" benchmarks/validation.py --page studies/results/validation_benchmark.json \
    > studies/results/validation_benchmark.md
"$PYTHON" examples/aimed_laser.py --out docs/images/laser.jpg > /dev/null
"$PYTHON" examples/train_quiet_laser.py --json > "$RUNS/quiet_laser.json"
cp "$RUNS/quiet_laser.json" studies/results
"$PYTHON" examples/show_quiet_laser.py studies/results/quiet_laser.json
