#!/usr/bin/env python3
"""Kills resumable runs at random moments, and looks at what they leave. Called by `make accept`; alone:

    scripts/kills.py RASTER [--kills N] [--seed N] [-- SIMPLIFY_OPTION...]

A run with --work-dir is started, killed (SIGKILL) and started again until it comes to its end; then the next begins. The
finished mesh must have the bytes of a run that nobody disturbed, nothing else may stand under its name before, and
nothing but the mesh is left in its folder. TERRABITE names another program than target/release/terrabite. The moments
follow from the seed and from the time that a run takes here, so a seed repeats a run only roughly.
"""

import argparse
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TARGET = ROOT / os.environ.get("CARGO_TARGET_DIR", "target")
TERRABITE = Path(os.environ.get("TERRABITE") or TARGET / "release" / "terrabite").absolute()
KILLED = -9


def main():
    arguments = parsed()
    draw = random.Random(arguments.seed)
    print(f"kills: seed {arguments.seed}, {arguments.kills} kills", file=sys.stderr)
    with tempfile.TemporaryDirectory(prefix="terrabite-kills-") as folder:
        scene = Scene(Path(folder), arguments.raster, arguments.options)
        kills = runs = 0
        while kills < arguments.kills:
            kills += scene.finish_under_kills(draw, arguments.kills - kills)
            runs += 1
    for fault in scene.faults:
        print(f"FAIL  {fault}")
    told = f"{kills} kills over {runs} resumed runs of {arguments.raster.name}, seed {arguments.seed}"
    print(f"{'FAIL' if scene.faults else 'ok'}    {told}: {len(scene.faults)} faults")
    sys.exit(1 if scene.faults else 0)


def parsed():
    parser = argparse.ArgumentParser(usage="%(prog)s RASTER [--kills N] [--seed N] [-- SIMPLIFY_OPTION...]")
    parser.add_argument("raster", type=lambda path: Path(path).absolute())
    parser.add_argument("--kills", type=int, default=300, help="how many (300)")
    parser.add_argument("--seed", type=int, default=random.SystemRandom().randrange(1 << 32), help="of the moments")
    words, options = sys.argv[1:], ["--max-error", "60", "--tile", "128"]
    if "--" in words:
        end = words.index("--")
        words, options = words[:end], words[end + 1 :]
    arguments = parser.parse_args(words)
    arguments.options = options
    return arguments


class Scene:
    """A raster, the mesh that is expected of it, and the faults found so far."""

    def __init__(self, folder, raster, options):
        self.faults = []
        self.output, self.work = folder / "output" / "tin.ply", folder / "work"
        self.output.parent.mkdir()
        self.command = [TERRABITE, "simplify", raster, self.output, "--quiet", *options]
        start = time.monotonic()
        subprocess.run(self.command, check=True)
        self.seconds = time.monotonic() - start
        self.expected = self.output.read_bytes()
        self.command += ["--work-dir", self.work]
        self.clear()

    def clear(self):
        for path in self.left():
            (self.output.parent / path).unlink()

    def left(self):
        return sorted(os.listdir(self.output.parent))

    def finish_under_kills(self, draw, most):
        """Brings one run to its end through at most `most` kills; returns how many there were."""
        kills = 0
        while (code := self.run(draw) if kills < most else self.wait()) == KILLED:
            kills += 1
            if self.output.exists() and not self.is_expected():
                self.faults.append(f"after kill {kills} of a run, {self.output.name} is there and not whole")
            if self.is_expected() and not (self.work / "staged").exists():
                # Killed when nothing was left to do but to remove the folder: the run is done.
                code = 0
                self.remove_lock()
                break
        if code != 0:
            self.faults.append(f"exit code {code} after {kills} kills")
        elif not self.is_expected():
            self.faults.append(f"other bytes after {kills} kills")
        for name in self.left():
            if name != self.output.name:
                self.faults.append(f"{name} is left behind after {kills} kills")
        # A run killed before it could note that it has made the folder leaves it there, empty, for anyone's.
        if self.work.exists() and os.listdir(self.work):
            self.faults.append(f"the work dir is left behind after {kills} kills")
        shutil.rmtree(self.work, ignore_errors=True)
        self.clear()
        return kills

    def remove_lock(self):
        """Removes the work dir if it holds nothing but the lock."""
        if self.work.exists() and set(os.listdir(self.work)) <= {"lock"}:
            shutil.rmtree(self.work)

    def run(self, draw):
        """Starts the program, kills it at some moment if it still runs then, and returns how it ended.

        The moment is anywhere; or near the start, where a run looks at what an earlier one has left; or when names in the
        output's folder have changed once or a few times.
        """
        process = subprocess.Popen(self.command)
        if (share := draw.choice([1.0, 0.1, None])) is not None:
            try:
                return process.wait(draw.uniform(0, self.seconds * share))
            except subprocess.TimeoutExpired:
                process.kill()
                return process.wait()
        names, changes = self.left(), draw.randrange(1, 5)
        while changes > 0 and process.poll() is None:
            found = self.left()
            changes -= found != names
            names = found
        process.kill()
        return process.wait()

    def wait(self):
        return subprocess.run(self.command).returncode

    def is_expected(self):
        return self.output.exists() and self.output.read_bytes() == self.expected


if __name__ == "__main__":
    main()
