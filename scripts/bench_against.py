"""This build against another commit's, in turn. Called by bench_quality.py for `--against REV`.

The other commit is built once, from its own files and with its own lock file, under `target/against/COMMIT`, and found
again there. Meshes of both are judged by this build's `terrabite verify`.
"""

import subprocess
import sys

from bench_common import (
    CPU, MIB, PEAK, ROOT, TARGET, TERRABITE, WORK, geometric, grouped, interleaved, median, note, print_table, simplify, verified,
)

HEADER = [
    "raster, tolerance", "quality", "triangles", "theirs", "÷ theirs", "tiles s", "theirs", "speed ÷ theirs", "whole s",
    "theirs", "speed ÷ theirs", "CPU s", "theirs", "÷ theirs", "peak MiB", "theirs", "÷ theirs",
]
SUMMARY = [
    "quality, geometric means", "over", "cases", "triangles ÷ theirs", "tiles, speed ÷ theirs", "whole, speed ÷ theirs",
    "CPU time ÷ theirs", "peak memory ÷ theirs",
]


class Build:
    """Another commit's program."""

    def __init__(self, revision):
        commit = git("rev-parse", "--verify", "--quiet", "--end-of-options", f"{revision}^{{commit}}")
        if commit is None:
            sys.exit(f"bench: {revision} is no commit of {ROOT}")
        self.commit = commit.decode().strip()
        self.title = git("show", "--no-patch", "--format=%h, %cs, %s", self.commit).decode().strip()
        folder = (TARGET / "against" / self.commit[:12]).absolute()
        self.program = folder / "target" / "release" / TERRABITE.name
        # It is there only once the build is done.
        if not self.program.exists():
            self.make(folder)

    def make(self, folder):
        note(f"building {self.title} in {folder}: once, some minutes")
        source = folder / "source"
        source.mkdir(parents=True, exist_ok=True)
        archive = git("archive", "--format=tar", self.commit)
        subprocess.run(["tar", "--extract", "--directory", source], input=archive, check=True)
        command = ["cargo", "build", "--release", "--locked", "--bin", "terrabite", "--target-dir", folder / "target"]
        if subprocess.run(command, cwd=source).returncode != 0:
            sys.exit(f"bench: {self.title} cannot be built (see above)")


def git(*arguments):
    """What git prints, None if it fails."""
    done = subprocess.run(["git", "-C", ROOT, *arguments], stdout=subprocess.PIPE)
    return done.stdout if done.returncode == 0 else None


class Pair:
    """The runs of both builds on one raster at one tolerance and quality."""

    def __init__(self, case, quality, is_large, runs, triangles):
        self.case, self.quality, self.is_large = case, quality, is_large
        self.triangles = triangles
        measures = (tiles_seconds, whole_seconds, CPU, PEAK)
        self.tiles, self.whole, self.cpu, self.peak = ([median(r, what) for r in runs] for what in measures)
        self.threads = [threads_used(r[-1].json()) for r in runs]

    def ratios(self):
        """Triangles, speed of the tiles, speed of the whole run, CPU time and peak memory; ours against theirs."""
        triangles, tiles, whole, cpu, peak = (
            ours / theirs for ours, theirs in (self.triangles, self.tiles, self.whole, self.cpu, self.peak)
        )
        return triangles, 1 / tiles, 1 / whole, cpu, peak

    def row(self):
        cells = [self.case, self.quality]
        seconds = "{:.2f}".format
        shown = [grouped, seconds, seconds, seconds, lambda peak: f"{peak / MIB:.0f}"]
        both = [self.triangles, self.tiles, self.whole, self.cpu, self.peak]
        for show, pair, ratio in zip(shown, both, self.ratios()):
            cells += [*map(show, pair), f"{ratio:.3f}"]
        return cells


def tiles_seconds(done):
    return done.json()["seconds"]["tiles"]


def whole_seconds(done):
    """Inside the process, from its start to the mesh on the disk."""
    return done.json()["seconds"]["total"]


def threads_used(report):
    """Older reports call what memory allows a plan."""
    return report.get("memory", report.get("plan"))["threads"]


def measure(raster, tolerance, quality, options, is_large, other, arguments):
    """Both builds in turn."""
    programs = {"ours": TERRABITE, "theirs": other.program}
    meshes = {name: WORK / f"against-{name}.ply" for name in programs}
    turns = {
        name: lambda name=name: simplify(programs[name], raster.path, meshes[name], tolerance, arguments.threads, options)
        for name in programs
    }
    runs = interleaved(arguments.rounds, arguments.patience, turns)
    counts = [verified(raster.path, mesh, tolerance)["triangles"] for mesh in meshes.values()]
    for mesh in meshes.values():
        mesh.unlink()
    pair = Pair(f"{raster.name}, {tolerance}", quality, is_large, list(runs.values()), counts)
    triangles, tiles, whole, cpu, peak = (f"{ratio:.3f}" for ratio in pair.ratios())
    note(f"{pair.case}, {quality}: triangles {triangles}, speed {tiles} ({whole} of all), CPU time {cpu}, memory {peak}")
    if pair.threads[0] != pair.threads[1]:
        note(f"ours ran on {pair.threads[0]} threads, theirs on {pair.threads[1]}")
    return pair


def report(pairs, other, arguments):
    print(f"Against {other.title}; {arguments.threads} threads, {arguments.rounds} runs of each in turn, medians\n")
    print_table(HEADER, [pair.row() for pair in pairs])
    print()
    rows = []
    for quality in dict.fromkeys(pair.quality for pair in pairs):
        every = [pair for pair in pairs if pair.quality == quality]
        large = [pair for pair in every if pair.is_large]
        for over, some in [("large rasters", large), ("all", every)]:
            if some and (over != "all" or some != large):
                means = [f"{geometric(ratios):.3f}" for ratios in zip(*(pair.ratios() for pair in some))]
                # Small rasters take no longer than to start.
                rows.append([quality, over, str(len(some)), *(means if over != "all" else [means[0], "", "", "", ""])])
    print_table(SUMMARY, rows)
