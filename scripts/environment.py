"""Environments with pinned packages of PyPI or npm, made once under the target folder; a second process waits for the first."""

import fcntl
import json
import shutil
import subprocess
import sys
import venv


def python_with(requirements, folder):
    """The Python of an environment with what the file `requirements` lists. It is made anew when the list changes."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    wanted, stamp, python = requirements.read_text(), folder / "requirements.txt", folder / "bin" / "python"
    with open(folder.with_name(folder.name + ".lock"), "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        # The stamp is written last, and removed with all else by `clear`.
        if not (python.exists() and stamp.exists() and stamp.read_text() == wanted):
            print(f"installing {requirements.name} into {folder}", file=sys.stderr)
            venv.create(folder, with_pip=True, clear=True)
            if subprocess.run([python, "-m", "pip", "install", "--quiet", "-r", requirements]).returncode != 0:
                sys.exit(f"{requirements.name} cannot be installed (see above)")
            stamp.write_text(wanted)
    return python


def node_modules_with(packages, folder):
    """A folder `node_modules` with packages of npm, such as playwright-core@1.65.1. It is made anew when the list changes."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    stamp, wanted = folder / "packages.json", json.dumps(packages)
    with open(folder.with_name(folder.name + ".lock"), "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        # The stamp is written last.
        if not (stamp.exists() and stamp.read_text() == wanted):
            print(f"installing {', '.join(packages)} into {folder}", file=sys.stderr)
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir()
            # Without one of its own, npm takes that of a folder above.
            (folder / "package.json").write_text("{}")
            options = ["--no-audit", "--no-fund", "--ignore-scripts", "--save-exact", "--loglevel=error"]
            if subprocess.run(["npm", "install", *options, *packages], cwd=folder).returncode != 0:
                sys.exit(f"npm cannot install {', '.join(packages)} (see above)")
            stamp.write_text(wanted)
    return folder / "node_modules"
