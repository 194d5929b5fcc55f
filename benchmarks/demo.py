"""How long `avsec demo` takes on a machine that has rendered and compiled nothing; prints JSON.

    python benchmarks/demo.py

Seconds from its start: `first_page` until there is a page to open, `first_scene` until that page
shows an attacked scene, `whole` until all of them and the drives are on it.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from avsec_gym.runs.run import usable_cores

PAGE = "report.html:"
"""Each line with it states what the page shows by now."""
STAGES = ("first_page", "first_scene")


def main() -> None:
    """Measure, print JSON."""
    with tempfile.TemporaryDirectory() as name:
        home = Path(name)
        places = {"HOME": home, "XDG_CACHE_HOME": home / "cache", "NUMBA_CACHE_DIR": home / "numba"}
        command = [sys.executable, "-m", "avsec_gym", "demo", "--out", str(home / "demo")]
        begun = time.perf_counter()
        demo = subprocess.Popen(
            command,
            env=os.environ | {key: str(place) for key, place in places.items()},
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        )  # fmt: skip
        assert demo.stdout is not None
        shown = []
        for line in demo.stdout:
            sys.stderr.write(line)
            if PAGE in line:
                shown.append(time.perf_counter() - begun)
        if demo.wait():
            raise SystemExit(f"the demo has ended with exit code {demo.returncode}")
        whole = time.perf_counter() - begun
    seconds = dict(zip(STAGES, shown, strict=False)) | {"whole": whole}
    result = {"cores": usable_cores()} | {key: round(value, 1) for key, value in seconds.items()}
    print(json.dumps(result, indent=1))


if __name__ == "__main__":
    main()
