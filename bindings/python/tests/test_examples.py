"""The examples run: scripts as they are, notebooks cell by cell."""
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

FOLDER = Path(os.environ.get("KMECH_SOURCE", Path(__file__).resolve().parents[3])) / "examples/python"


@pytest.mark.parametrize("script", sorted(FOLDER.glob("*.py")), ids=lambda p: p.name)
def test_script(script):
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0 and done.stdout and not done.stderr, done.stderr


@pytest.mark.parametrize("notebook", sorted(FOLDER.glob("*.ipynb")), ids=lambda p: p.name)
def test_notebook(notebook):
    cells, names = json.loads(notebook.read_text())["cells"], {"__name__": "__main__"}
    code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    assert code
    for i, text in enumerate(code):
        *body, last = text.rstrip().splitlines()
        exec(compile("\n".join(body), f"{notebook.name}[{i}]", "exec"), names)
        shown = eval(compile(last, f"{notebook.name}[{i}]", "eval"), names)
        if hasattr(shown, "_repr_svg_"):
            assert "<svg" in shown._repr_svg_()
        else:
            assert repr(shown)
