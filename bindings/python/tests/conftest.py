"""What the tests share: the models of the project."""
import os
from pathlib import Path

import pytest

import kmech

SOURCE = Path(os.environ.get("KMECH_SOURCE", Path(__file__).resolve().parents[3]))


@pytest.fixture
def source():
    return SOURCE


@pytest.fixture
def brake():
    return kmech.load(SOURCE / "models/brake.json")


@pytest.fixture
def fourbar():
    return kmech.load(SOURCE / "models/fourbar.json")


@pytest.fixture
def iiwa():
    return kmech.load(SOURCE / "models/iiwa14.json")
