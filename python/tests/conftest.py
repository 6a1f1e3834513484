"""Terrains for tests, and the command that was built with the package."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest


def hills(rows: int = 90, columns: int = 120) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Hills with heights that single precision holds."""
    row, column = np.mgrid[:rows, :columns]
    smooth = 200 + 40 * np.sin(column / 17) * np.cos(row / 13) + 15 * np.sin((column + 2 * row) / 5)
    return np.round(smooth * 8) / 8


@pytest.fixture
def dem() -> np.ndarray[Any, np.dtype[np.float64]]:
    """Hills, 90 rows of 120."""
    return hills()


@pytest.fixture(scope="session")
def command() -> Path:
    """The command; `make test` says where it is."""
    return Path(os.environ["TERRABITE"]).resolve()


def run(command: Path, *words: object) -> str:
    """What the command prints."""
    done = subprocess.run([str(word) for word in (command, *words)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def is_long() -> bool:
    """Whether `make test-long` runs."""
    return os.environ.get("TERRABITE_LONG_TESTS") == "1"
