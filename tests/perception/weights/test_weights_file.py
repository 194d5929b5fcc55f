"""The file of a detector's weights is known without making the detector."""

from __future__ import annotations

from pathlib import Path

from avsec_gym.perception.weights.weights_file import weights_file_hash


def test_weights_are_known_by_their_file(tmp_path: Path) -> None:
    (tmp_path / "mine.safetensors").write_bytes(b"tensors")
    own = {"name": "dsgn", "weights": str(tmp_path / "mine.safetensors")}
    assert weights_file_hash("dsgn") != weights_file_hash("stereo_rcnn")
    assert weights_file_hash(own) not in (None, weights_file_hash("dsgn"))
    assert weights_file_hash("no detector") is None
