"""Builds the wheel of python/, installs it into an environment of its own under the target folder, and tests it there.

    scripts/python_tests.py             the wheel for tests, built without link-time optimisation; mypy and all tests
    scripts/python_tests.py --readers   the same wheel, only the tests that need a viewer
    scripts/python_tests.py --install   the same wheel, installed; prints the Python that has it
    scripts/python_tests.py --wheel     the wheel of a release; tests that need no more than numpy, in a clean environment
"""

import argparse
import fcntl
import os
import subprocess
import sys
import venv
from pathlib import Path

from environment import python_with

ROOT = Path(__file__).resolve().parent.parent
TARGET = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")).resolve()
PACKAGE = ROOT / "python"
SCRIPTS = ROOT / "scripts"
# Features differ from those of the command: in one folder each build would push out the other.
BUILDS = TARGET / "python"
SKIP = "TERRABITE_SKIP_READERS"
# What a clean environment has, and the tests that need no more.
CLEAN = ["numpy==2.4.6", "pytest==9.2.0"]
CLEAN_TESTS = ["test_arrays.py", "test_control.py", "test_clean.py"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--readers", action="store_true", help="only the tests that need a viewer")
    parser.add_argument("--install", action="store_true", help="install the wheel, and print the Python that has it")
    parser.add_argument("--wheel", action="store_true", help="the wheel of a release")
    arguments = parser.parse_args()
    if os.environ.get(SKIP) == "1":
        print(f"skipped: {SKIP}=1")
        return
    BUILDS.mkdir(parents=True, exist_ok=True)
    with open(BUILDS / "tests.lock", "w") as lock:
        # One wheel at a time is built, installed and tested.
        fcntl.flock(lock, fcntl.LOCK_EX)
        if arguments.wheel:
            release()
        elif arguments.install:
            print(installed("python"))
        else:
            test(arguments.readers)


def run(*command, **variables):
    """Runs a program in the package's folder; ends with it where it fails. (`python -m pytest` would import the package from
    there, in place of the one that is installed.)"""
    done = subprocess.run([str(word) for word in command], cwd=PACKAGE, env={**os.environ, **variables})
    if done.returncode != 0:
        sys.exit(done.returncode)


def built(python, folder, *options):
    """The wheel, built by maturin of an environment."""
    for old in folder.glob("*.whl"):
        old.unlink()
    variables = {"CARGO_TARGET_DIR": str(BUILDS), "PATH": f"{python.parent}{os.pathsep}{os.environ['PATH']}"}
    run(python.parent / "maturin", "build", "--locked", "--quiet", "--interpreter", python, "--out", folder, *options, **variables)
    (wheel,) = folder.glob("*.whl")
    return wheel


def install(python, *what):
    run(python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *what)


def installed(name):
    """The Python of an environment that has the wheel."""
    python = python_with(SCRIPTS / f"{name}-requirements.txt", TARGET / "environments" / name)
    install(python, "--force-reinstall", "--no-deps", built(python, BUILDS / "wheels", "--profile", "wheel"))
    return python


def test(readers):
    python = installed("python-readers" if readers else "python")
    variables = {"TERRABITE": str(TARGET / "debug" / "terrabite")}
    if readers:
        run(python.parent / "pytest", "-m", "readers", **variables)
        return
    run(python.parent / "mypy", "--cache-dir", BUILDS / "mypy", "terrabite", "tests/typed.py")
    run(python.parent / "pytest", "-m", "not readers", "tests", "--doctest-modules", "--pyargs", "terrabite", **variables)


def release():
    builder = python_with(SCRIPTS / "wheel-requirements.txt", TARGET / "environments" / "wheel")
    wheel = built(builder, TARGET / "wheels", "--release", "--zig", "--compatibility", "manylinux2014")
    clean = TARGET / "environments" / "clean"
    venv.create(clean, with_pip=True, clear=True)
    python = clean / "bin" / "python"
    install(python, wheel, *CLEAN)
    run(python.parent / "pytest", *(Path("tests") / name for name in CLEAN_TESTS))
    print(f"{wheel}: {wheel.stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main()
