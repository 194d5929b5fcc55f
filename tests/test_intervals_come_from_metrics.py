"""Intervals and comparisons come from `avsec_gym.metrics`, which heeds clusters: by names.

Nothing outside of it draws bootstrap samples, takes the quantiles of a 95 % interval, or asks for
the interval of a share as if its cases were independent.  What a name does not show is found by
reading.
"""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
METRICS = ROOT / "avsec_gym/metrics"
PLACES = ("avsec_gym", "studies", "examples", "benchmarks")
ONLY_INSIDE = {
    "wilson_interval": "share_of",
    "clustered_interval": "share_of",
    "design_effect": "share_of",
    "mcnemar_p": "paired_differences or paired_difference",
    "draw_resamples": "ClusterBootstrap",
}
"""Functions of metrics that know no clusters by themselves, and what to call instead."""
TESTS_OF_SCIPY = {
    "bootstrap", "binomtest", "binom", "permutation_test", "monte_carlo_test", "rankdata",
    "spearmanr", "kendalltau", "mannwhitneyu", "ttest_rel", "ttest_ind", "wilcoxon",
    "proportion_ci", "fisher_exact", "barnard_exact",
}  # fmt: skip
INDEPENDENT = {
    "avsec_gym/experiments/chapter3/diagrams/thesis_marks.py": "an example in a docstring",
    "avsec_gym/experiments/chapter4/joined/rates.py": "a place is seen at one instant",
    "studies/chapter3/real_frames.py": "draws of the attacks on one frame, of which a row states",
    "studies/chapter3/shipped_fits/judge.py": "each frame is a drive of its own; else as above",
    "studies/chapter4/shares.py": "an example in a docstring",
    "studies/reproduce/page.py": "results that hold a share and its number of independent cases",
}
"""Who counts cases without clusters (`Share.of_counts`), and why these have none."""
_LEVELS = {0.025, 0.975, 2.5, 97.5}


def sources() -> list[Path]:
    """All modules outside of metrics."""
    every = [path for place in PLACES for path in sorted((ROOT / place).rglob("*.py"))]
    return [path for path in every if METRICS not in path.parents]


def faults(tree: ast.AST) -> Iterator[str]:
    """What a module does that is metrics' own."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            for name in (each.name for each in node.names):
                if name in ONLY_INSIDE:
                    yield f"imports {name}; call {ONLY_INSIDE[name]}"
                if node.module == "scipy.stats" and name in TESTS_OF_SCIPY:
                    yield f"imports scipy.stats.{name}"
        if not isinstance(node, ast.Call):
            continue
        called = _words(node.func)
        given = [*node.args, *(word.value for word in node.keywords)]
        numbers = {each.value for part in given for each in ast.walk(part) if _is_number(each)}
        names = {_words(each)[-1] for part in given for each in ast.walk(part) if _words(each)}
        if re.search("quantile|percentile", called[-1] if called else "") and (
            numbers & _LEVELS or {"LOW_AND_HIGH", "_LOW_AND_HIGH"} & names
        ):
            yield f"takes the quantiles of an interval by {called[-1]}"
        if called and called[-1] in ("integers", "choice", "multinomial", "permutation"):
            if called[-1] == "multinomial" and called[0] != "torch":
                yield "draws by multinomial"
            elif any("resample" in name.lower() for name in names):
                yield f"draws resamples by {called[-1]}"
        if called[:1] == ["stats"] and called[-1] in TESTS_OF_SCIPY:
            yield f"calls scipy.stats.{called[-1]}"


def _words(node: ast.AST) -> list[str]:
    """The names of a dotted name, such as ``np``, ``random``, ``choice``; of a call those of it."""
    if isinstance(node, ast.Name):
        return [node.id]
    if isinstance(node, ast.Attribute):
        return [*(_words(node.value) or [""]), node.attr]
    return []


def _is_number(node: ast.AST) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, int | float)


@pytest.mark.parametrize("place", PLACES)
def test_intervals_and_draws_are_those_of_metrics(place: str) -> None:
    found = {
        str(path.relative_to(ROOT)): wrong
        for path in sources()
        if (ROOT / place) in path.parents
        for wrong in [list(faults(ast.parse(path.read_text())))]
        if wrong
    }
    assert not found


def test_notebooks_keep_to_it_too() -> None:
    for path in sorted((ROOT / "examples").rglob("*.ipynb")):
        cells = json.loads(path.read_text())["cells"]
        code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
        plain = "\n".join(line for line in "\n".join(code).splitlines() if line[:1] not in "%!")
        assert not list(faults(ast.parse(plain))), path.name


def test_cases_without_clusters_are_listed_with_their_reason() -> None:
    counted = {
        str(path.relative_to(ROOT)) for path in sources() if "Share.of_counts(" in path.read_text()
    }
    assert counted == set(INDEPENDENT)


@pytest.mark.parametrize(
    ("source", "said"),
    [
        ("from avsec_gym.metrics.intervals import wilson_interval", "share_of"),
        ("from avsec_gym.metrics.cluster_bootstrap import draw_resamples", "ClusterBootstrap"),
        ("low, high = np.quantile(means, [0.025, 0.975])", "quantiles"),
        ("np.nanpercentile(drawn, (2.5, 97.5))", "quantiles"),
        ("np.quantile(drawn, _LOW_AND_HIGH)", "quantiles"),
        ("np.random.default_rng(0).multinomial(n, even, size=_RESAMPLES)", "multinomial"),
        ("rng.integers(len(counts), size=(_RESAMPLES, len(counts)))", "resamples"),
        ("generator.choice(scenes, (self.resamples, n))", "resamples"),
        ("from scipy.stats import bootstrap", "bootstrap"),
        ("from scipy import stats\nstats.spearmanr(a, b)", "spearmanr"),
    ],
)
def test_what_is_forbidden_is_found(source: str, said: str) -> None:
    (wrong,) = faults(ast.parse(source))
    assert said in wrong


@pytest.mark.parametrize(
    "source",
    [
        "np.quantile(scores, [0.0, 0.25, 0.5])",
        "torch.multinomial(areas, count, replacement=True)",
        "average_precision(truth, boxes, resamples=_RESAMPLES)",
        "rng.integers(len(lanes))",
        "np.percentile(grey, [5, 50, 95])",
        "from avsec_gym.metrics.clustered_shares import share_of",
    ],
)
def test_what_is_allowed_is_not(source: str) -> None:
    assert not list(faults(ast.parse(source)))
