"""What the tests of faults share: a tool's command in a folder of its own, with a plain environment."""
import json
import os
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

PLAIN = {"PATH": "/usr/bin:/bin", "HOME": "/root", "LC_ALL": "C.UTF-8", "OPENBLAS_NUM_THREADS": "1",
         "LSAN_OPTIONS": "detect_leaks=0"}


class Box:
    """A folder that goes when it is no longer needed."""

    def __enter__(self):
        self.path = tempfile.mkdtemp()
        os.chmod(self.path, 0o777)
        return self.path

    def __exit__(self, *unused):
        shutil.rmtree(self.path, ignore_errors=True)


def command(tools, line):
    tool, *rest = line.split()
    return [str(tools / tool), *rest]


def run(tools, line, box, env=PLAIN, **options):
    options = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "timeout": 120, **options}
    return subprocess.run(command(tools, line), cwd=box, env=env, **options)


def files(box):
    """What a run left, but for stores, which are a database's affair, and notes of the test's own. Ways to a mesh of the tree depend
    on how deep the box lies, where both are below one folder: they count as one step up."""
    return {p.name: re.sub(rb"(?:\.\./)+", b"../", p.read_bytes()) for p in Path(box).iterdir()
            if "sqlite" not in p.name and p.name not in (".out", ".said", ".place", ".status")}


def is_whole(name, found, wanted):
    """The file that was wanted, or what a run that ended early says it is: rows up to there, a record that tells why, a
    picture of it."""
    data = found[name]
    if name not in wanted or data == wanted[name]:
        return name in wanted
    if name.endswith(".json"):
        return json.loads(data).get("complete") is False
    if name.endswith(".svg"):
        records = [other for other in found if other.endswith(".json")]
        return data.endswith(b"</svg>\n") and any(json.loads(found[r]).get("complete") is False for r in records)
    return name.endswith(".csv") and wanted[name].startswith(data) and data.endswith(b"\n")
