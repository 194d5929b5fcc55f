#!/bin/sh
# Makes the pages of chapter 3 in docs/results: are attacks on LiDAR and cameras noticed, and are the
# attacked sensors named, and what does it cost an attacker to stay unnoticed?  Hours; every step but
# the last three, minutes each, goes on where it was stopped.  Environment: PYTHON; RUNS, where runs lie;
# LIMIT, moments of each part, which are rendered once into the cache; KITTI, the root of the object
# benchmark, whose frames with both images and a scan are attacked, too.
set -eu
cd "$(dirname "$0")/.."
PYTHON=${PYTHON:-python}
RUNS=${RUNS:-runs}
avsec() { "$PYTHON" -m avsec_gym "$@"; }
for DEPTH in sgbm psmnet; do
    RUN=$RUNS/identification_$DEPTH
    avsec run identification knowing --limit "${LIMIT:-1000}" --options "depth=$DEPTH" --threads 1 --out "$RUN"
    avsec report "$RUN" --markdown "docs/results/identification_$DEPTH.md" --overwrite --json \
        > "$RUN.json"
    sed "s|$PWD/||g" "$RUN.json" > "docs/results/identification_$DEPTH.json"
done
[ -z "${KITTI:-}" ] || "$PYTHON" -m avsec_gym.experiments.chapter3.real_frames --kitti "$KITTI" \
    --json docs/results/identification_real.json
"$PYTHON" benchmarks/validation.py > "$RUNS/validation_benchmark.json"
cp "$RUNS/validation_benchmark.json" docs/results
"$PYTHON" examples/train_quiet_laser.py --json > "$RUNS/quiet_laser.json"
cp "$RUNS/quiet_laser.json" docs/results
