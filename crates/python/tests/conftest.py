"""Where the files of the repository are, and the program to compare with."""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
CONFIG = ROOT / "config"


def pytest_addoption(parser):
    """Adds where the cases lie that all kernels are compared on."""
    parser.addoption("--cases", type=Path, help="a folder of folders with a.stl, b.stl, pose.txt")


def pytest_generate_tests(metafunc):
    """Gives a test of cases one after another."""
    if "case" in metafunc.fixturenames:
        folder = metafunc.config.getoption("cases")
        found = sorted(path.parent for path in folder.glob("*/pose.txt")) if folder else []
        if folder and not found:
            raise pytest.UsageError(f"--cases {folder}: no folder in it has a pose.txt")
        metafunc.parametrize("case", found, ids=lambda path: path.name)


@pytest.fixture(scope="session")
def config():
    """The folder of policies, curves and scenarios."""
    return CONFIG


@pytest.fixture(scope="session")
def root():
    """The folder of the whole project."""
    return ROOT


@pytest.fixture(scope="session")
def program():
    """Returns a function that ranks with the command line, and gives the answer's text."""
    binary = os.environ.get("TROLLEY") or shutil.which("trolley")
    if not binary:
        pytest.skip("TROLLEY names no program to compare with")

    def answer(path, *more):
        command = [binary, "rank", str(path), "--json", "--in-process", *more]
        text = subprocess.run(command, capture_output=True, text=True, check=False).stdout
        begin = text.index('"answer": ') + len('"answer": ')
        end = min(text.index(f'\n  "{key}": ', begin) for key in ("explanation", "run")
                  if f'\n  "{key}": ' in text)
        return without_space(text[begin:end].rstrip().removesuffix(",")).encode()

    return answer


def without_space(text):
    """JSON without the white space between its words."""
    return "".join(re.findall(r'"(?:[^"\\]|\\.)*"|[^\s"]+', text))
