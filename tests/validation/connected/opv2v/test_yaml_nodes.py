"""YAML of other people's folders: large files are refused before they are taken apart."""

from pathlib import Path

import pytest

from avsec_gym.errors import DataError
from avsec_gym.validation.connected.opv2v.yaml_nodes import MAX_YAML_BYTES, read_yaml_mapping


def test_a_file_of_four_megabytes_is_read_and_a_larger_one_refused(tmp_path: Path) -> None:
    pytest.importorskip("yaml")
    path, begin = tmp_path / "000069.yaml", b"speed: 3.5\n#"
    assert MAX_YAML_BYTES == 4 * 1024 * 1024
    path.write_bytes(begin + b" " * (MAX_YAML_BYTES - len(begin)))
    read_yaml_mapping(path)
    path.write_bytes(begin + b" " * (MAX_YAML_BYTES - len(begin) + 1))
    with pytest.raises(DataError, match=r"000069\.yaml"):
        read_yaml_mapping(path)
