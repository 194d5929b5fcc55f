#!/bin/sh
# Makes the pages of chapter 3 in docs/results: are attacks on LiDAR and cameras noticed, and are the
# attacked sensors named, and what does it cost an attacker to stay unnoticed?  Hours; every step but
# the last two, minutes each, goes on where it was stopped.  Environment: PYTHON; RUNS, where runs lie;
# LIMIT, moments of each part, which are rendered once into the cache.
set -eu
cd "$(dirname "$0")/.."
PYTHON=${PYTHON:-python}
RUNS=${RUNS:-runs}
avsec() { "$PYTHON" -m avsec_gym "$@"; }
for DEPTH in sgbm psmnet; do
    RUN=$RUNS/identification_$DEPTH
    avsec run identification --limit "${LIMIT:-1000}" --options "depth=$DEPTH" looked_at=150 --threads 1 --out "$RUN"
    avsec report "$RUN" --markdown "docs/results/identification_$DEPTH.md" --overwrite --json \
        > "$RUN.json"
    sed "s|$PWD/||g" "$RUN.json" > "docs/results/identification_$DEPTH.json"
done
"$PYTHON" benchmarks/validation.py > "$RUNS/validation_benchmark.json"
cp "$RUNS/validation_benchmark.json" docs/results
"$PYTHON" examples/train_quiet_laser.py --json > "$RUNS/quiet_laser.json"
cp "$RUNS/quiet_laser.json" docs/results
