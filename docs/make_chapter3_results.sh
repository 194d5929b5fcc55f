#!/bin/sh
# Makes the pages of chapter 3 in docs/results: are attacks on LiDAR and cameras noticed, and are the
# attacked sensors named?  Hours; every step goes on where it was stopped.  Environment: PYTHON; RUNS,
# where runs lie; LIMIT, moments of each part, which are rendered once into the cache.
set -eu
cd "$(dirname "$0")/.."
PYTHON=${PYTHON:-python}
RUNS=${RUNS:-runs}
avsec() { "$PYTHON" -m avsec_gym "$@"; }
for DEPTH in sgbm psmnet; do
    RUN=$RUNS/identification_$DEPTH
    avsec run identification --limit "${LIMIT:-1000}" --options "depth=$DEPTH" --threads 1 --out "$RUN"
    avsec report "$RUN" --markdown "docs/results/identification_$DEPTH.md" --overwrite --looked-at 690 --json \
        > "$RUN.json"
    sed "s|$PWD/||g" "$RUN.json" > "docs/results/identification_$DEPTH.json"
done
"$PYTHON" benchmarks/validation.py > "$RUNS/validation_benchmark.json"
cp "$RUNS/validation_benchmark.json" docs/results
