"""No module of the package opens files or makes folders by itself: all go through one door.

Beyond it, a pipe blocks for ever, a link to ``/dev/zero`` fills the memory, and a damaged file is
an error of whatever library reads it; a file where a folder is needed is an error that does not say
so.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import avsec_gym

PACKAGE = Path(avsec_gym.__file__).parent

FORBIDDEN = {
    # Python's own ways to a file's content; `storage` has the others.
    "open", "io.open", "io.FileIO", "os.open", "os.fdopen", "codecs.open", ".read_text",
    ".read_bytes", ".open",
    "json.load", "json.loads", "pickle.load", "pickle.loads", "pickle.Unpickler", "marshal.load",
    "shelve.open", "csv.reader", "mmap.mmap", "gzip.open", "bz2.open", "lzma.open", "tarfile.open",
    "zipfile.ZipFile", "zipfile.Path", "tomllib.load", "sqlite3.connect",
    "configparser.ConfigParser",
    "shutil.unpack_archive", "ElementTree.parse", "ElementTree.iterparse", "ElementTree.fromstring",
    "ElementTree.XML", "minidom.parse", "sax.parse",
    # Its ways to write one, and to make a folder.
    ".write_text", ".write_bytes", ".mkdir", ".touch", "os.mkdir", "os.makedirs",
    "logging.FileHandler", "shutil.copyfile", "shutil.copy", "shutil.copy2", "os.replace",
    "os.rename", "cv2.imwrite", "numpy.savetxt", "safetensors.torch.save_file", ".write_to_file",
    # Libraries.
    "numpy.load", "numpy.fromfile", "numpy.memmap", "numpy.loadtxt", "numpy.genfromtxt",
    "numpy.lib.format.open_memmap",
    "cv2.imread", "cv2.imreadmulti", "cv2.VideoCapture", "cv2.FileStorage", "PIL.Image.open",
    "imageio.imread", "plt.imread", "matplotlib.image.imread", "torch.load", "torch.jit.load",
    "torch.from_file", "load_file", "safe_open", "safetensors.torch.load_file", "yaml.load",
    "yaml.safe_load", "pandas.read_csv", "CommonRoadFileReader",
}  # fmt: skip
DOTTED = tuple(name for name in FORBIDDEN if name[0].isupper() or "." in name[1:])
"""What a longer name may end in, such as ``xml.etree.ElementTree.parse``."""

REASONS = {
    # The door itself.
    "storage/regular_files.py": {"os.fdopen", "os.open"},
    "storage/json_files.py": {"json.loads"},
    "storage/npz_files.py": {"numpy.load"},
    "storage/archives.py": {"zipfile.ZipFile", ".open"},
    # Bytes that came through it.
    "perception/weights/tensor_files.py": {"safetensors.torch.load"},
    "scenario/commonroad/reading.py": {
        ".open",
        "commonroad.common.file_reader.CommonRoadFileReader",
    },
    # What one process of ours sends to another.
    "worker_processes.py": {"pickle.loads"},
    "perception/training/batches.py": {"pickle.loads"},
    # A variable of this name.
    "commands/validation_line.py": {"open"},
    # A database in memory, for its schema; and those that `check_files` has looked at.
    "runs/soundness.py": {"sqlite3.connect"},
    "runs/store.py": {"sqlite3.connect"},
    "runs/run_folder.py": {"sqlite3.connect"},
    # Texts that this process, or one that it has started, has made itself.
    "runs/experiment.py": {"json.loads"},
    "perception/training/training_run.py": {"json.loads"},
    "perception/weights/recorded.py": {"json.loads"},
    "validation/validation_folder.py": {"json.loads"},
    # A text that the door has read, with its remedy.
    "agents/yaml_files.py": {"yaml.safe_load"},
    # Written, not read.
    "storage/atomic_write.py": {"open", "os.replace"},
    "storage/npy_rows.py": {"io.FileIO"},
    "storage/folders.py": {".mkdir"},
    "runs/run_log.py": {"logging.FileHandler"},
    # A video in memory.
    "drawing/video.py": {".open"},
    # Into a folder that no one else knows.
    "scenario/commonroad/writing.py": {".write_to_file", ".read_bytes"},
    # A standard stream, by its number.
    "commands/process.py": {"os.open", "os.fdopen"},
    # The package's own sources, and places for compiled kernels, of which it has others.
    "kernels.py": {".read_bytes", ".mkdir"},
    # The package's own style and script.
    "experiments/chapter5/section/sections.py": {".read_text"},
    "drawing/turnable_scene/page_part.py": {".read_text"},
    # Below the user's folder for caches.
    "world/textures/library.py": {"os.fdopen", "os.replace"},
    # A folder, for its lock.
    "storage/folder_lock.py": {"os.open"},
    # `RunFolder.open`.
    "commands/report.py": {".open"},
    "benchmark/making.py": {".open"},
    "commands/demo.py": {".open"},
}
"""What modules may call by themselves; each for the reason above it."""


def test_everything_goes_through_the_door() -> None:
    found = {
        path.relative_to(PACKAGE).as_posix(): calls
        for path in sorted(PACKAGE.rglob("*.py"))
        if (calls := set(forbidden_calls(ast.parse(path.read_text()))))
    }
    unknown = {name: calls - REASONS.get(name, set()) for name, calls in found.items()}
    assert not {name: sorted(calls) for name, calls in unknown.items() if calls}
    # A reason that is none any more must not excuse the next one.
    needless = {name: calls - found.get(name, set()) for name, calls in REASONS.items()}
    assert not {name: sorted(calls) for name, calls in needless.items() if calls}


def forbidden_calls(tree: ast.Module) -> Iterator[str]:
    """Functions that are called, or handed on, under any name that an import gives them."""
    meant: dict[str, str] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                if alias.asname:
                    meant[alias.asname] = alias.name
        elif isinstance(node, ast.ImportFrom):
            meant |= {each.asname or each.name: f"{node.module}.{each.name}" for each in node.names}
    for node in ast.walk(tree):
        if isinstance(node, (ast.Name, ast.Attribute)):
            first, dot, rest = ast.unparse(node).partition(".")
            name = meant.get(first, first) + dot + rest
            if name in FORBIDDEN or any(name.endswith(f".{each}") for each in DOTTED):
                yield name
            elif isinstance(node, ast.Attribute) and f".{node.attr}" in FORBIDDEN:
                yield f".{node.attr}"


def test_the_net_holds() -> None:
    """Code that may be written some day."""
    for line in (
        "with open(path) as file: pass",
        "Path(path).read_text()",
        "from zipfile import ZipFile\nimport zipfile\nzipfile.ZipFile(path)",
        "import numpy\nnumpy.load(path)",
        "import numpy as np\nlist(map(np.load, paths))",
        "import xml.etree.ElementTree\nxml.etree.ElementTree.parse(path)",
        "import commonroad.common.file_reader as reader\nreader.CommonRoadFileReader(path)",
        "import sqlite3\nsqlite3.connect(path)",
        "from torch import load as read\nread(path)",
    ):
        assert list(forbidden_calls(ast.parse(line))), line
    for line in (
        "from avsec_gym.storage.text_files import read_text\nread_text(path)",
        "x.opened()",
    ):
        assert not list(forbidden_calls(ast.parse(line))), line
