"""Virtual environments with pinned packages, made once under the target folder; a second process waits for the first."""

import fcntl
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
