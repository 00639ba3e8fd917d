"""Studies whose folder is an object store: named by URL, read and written with fsspec.

A machine copies plan and inputs to its own disk, runs a shard there, and puts the files of the
finished shard into the store, the seal last: without it a shard does not count. Nothing is locked.
Two machines that run the same shard put the same bytes.

A shard is run by a child, so that a scene that takes it down is noted on this machine's disk, and
is a row after three tries.
"""

import atexit
import os
import shutil
import subprocess
import sys
import tempfile

from . import _core
from ._errors import InputError, TrolleyError

PARTS = ("plan.json", "inputs.parquet", "inputs", "judges")
SEAL = "seal.json"
"""So often a shard is begun on one machine: a scene that takes its process down needs three."""
TRIES = 20

_stores = {}


def is_url(folder):
    """Whether a folder is named by URL."""
    return isinstance(folder, str) and "://" in folder


def at(url):
    """The store of a study, with a copy of its plan that this process keeps."""
    if url not in _stores:
        _stores[url] = Store(url)
    return _stores[url]


def put(folder, url):
    """Puts a study that was planned into a store."""
    files, root = _opened(url)
    for name in PARTS[1:] + PARTS[:1]:
        path = os.path.join(folder, name)
        if os.path.isdir(path):
            for inside, _, names in os.walk(path):
                for file in names:
                    _put(files, os.path.join(inside, file), root, folder)
        elif os.path.exists(path):
            _put(files, path, root, folder)


def _put(files, path, root, folder):
    target = f"{root}/{os.path.relpath(path, folder)}"
    files.makedirs(target.rsplit("/", 1)[0], exist_ok=True)
    files.put_file(path, target)


def _opened(url):
    try:
        import fsspec
    except ImportError as error:
        remedy = "pip install 'trolley-av[store]', and what its kind of store needs"
        raise InputError(f"no store can be opened: {error}", remedy=remedy,
                         exit_code=78) from error
    try:
        files, root = fsspec.core.url_to_fs(url)
    except (ImportError, ValueError) as error:
        raise InputError(f"{url}: {error}", remedy="install what this kind of store needs",
                         exit_code=78) from error
    return files, root.rstrip("/")


class Store:
    """A study in a store."""

    def __init__(self, url):
        self.files, self.root = _opened(url)
        if not self.files.exists(f"{self.root}/{PARTS[0]}"):
            remedy = "plan it there: trolley_av.study.plan(spec, url)"
            raise InputError(f"{url} holds no study", remedy=remedy, exit_code=65)
        self.copy = tempfile.mkdtemp(prefix="trolley-study-")
        atexit.register(shutil.rmtree, self.copy, ignore_errors=True)
        for name in PARTS:
            self._get(name)
        for name in ("shards", "attempts", "tmp"):
            os.makedirs(os.path.join(self.copy, name), exist_ok=True)

    def _get(self, name):
        """Copies a file or a folder, if the store has it."""
        for path in self.files.find(f"{self.root}/{name}"):
            target = os.path.join(self.copy, path[path.index(self.root) + len(self.root) + 1:])
            os.makedirs(os.path.dirname(target), exist_ok=True)
            self.files.get_file(path, target)

    def get_shards(self):
        """Copies all finished shards; returns the folder of the copy."""
        self.files.invalidate_cache()
        for name in os.listdir(os.path.join(self.copy, "shards")):
            shutil.rmtree(os.path.join(self.copy, "shards", name))
        self._get("shards")
        return self.copy

    def put_shard(self, shard):
        """Puts a shard into the store, its seal last."""
        folder = os.path.join(self.copy, f"shards/{shard:06}")
        for name in sorted(os.listdir(folder), key=lambda name: (name == SEAL, name)):
            _put(self.files, os.path.join(folder, name), self.root, self.copy)

    def run_shard(self, shard):
        """Runs a shard, unless the store has it and it is sound. Returns JSON."""
        folder = os.path.join(self.copy, f"shards/{shard:06}")
        shutil.rmtree(folder, ignore_errors=True)
        self.files.invalidate_cache()
        if self.files.exists(f"{self.root}/shards/{shard:06}/{SEAL}"):
            self._get(f"shards/{shard:06}")
        before = _identity(folder)
        command = [sys.executable, "-m", "trolley_av.study", self.copy, "--shard", str(shard)]
        for _ in range(TRIES):
            child = subprocess.run(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                   stderr=subprocess.PIPE, text=True, check=False)
            if child.returncode >= 0:
                break
        if child.returncode != 0:
            said = child.stderr.strip() or f"its process ended with {child.returncode}"
            raise TrolleyError(f"shard {shard}: {said}")
        text = _core.study_run_shard(self.copy, shard)
        if _identity(folder) != before:
            self.put_shard(shard)
            text = text.replace('"was_finished":true', '"was_finished":false')
        shutil.rmtree(folder, ignore_errors=True)
        return text


def _identity(folder):
    """What changes when a shard is ranked again: it is renamed to its place."""
    try:
        return os.stat(folder).st_ino
    except FileNotFoundError:
        return None
