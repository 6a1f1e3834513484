"""What the benchmarks share: running a program and measuring it from outside, tables, the machine's description."""

import json
import math
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TARGET = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
TERRABITE = TARGET / "release" / "terrabite"
GDAL_FLOOR = TARGET / "release" / "examples" / "gdal_floor"
WORK = TARGET / "bench"
MIB = 1 << 20


@dataclass
class Run:
    """One run of a program, measured by the system when it ended, and what it printed."""

    wall: float
    cpu: float
    peak: int
    printed: str
    code: int = 0

    def json(self):
        return json.loads(self.printed)


def run(*command, may_fail=False):
    """Runs a program to its end. The caller's own memory would count as the child's, so keep it small."""
    command = [str(part) for part in command]
    with tempfile.TemporaryFile("w+") as out:
        # A process's peak memory includes its parent's for a moment: this one imports nothing large.
        start = time.perf_counter()
        pid = os.posix_spawn(
            command[0], command, os.environ, file_actions=[(os.POSIX_SPAWN_DUP2, out.fileno(), sys.stdout.fileno())]
        )
        _, status, used = os.wait4(pid, 0)
        wall = time.perf_counter() - start
        out.seek(0)
        printed = out.read()
    code = os.waitstatus_to_exitcode(status)
    if code != 0 and not may_fail:
        sys.exit(f"bench: exit code {code} of {' '.join(command)}\n{printed}")
    # Linux counts ru_maxrss in KiB, macOS in bytes.
    unit = 1 if sys.platform == "darwin" else 1024
    return Run(wall, used.ru_utime + used.ru_stime, used.ru_maxrss * unit, printed, code)


def settle(patience):
    """Waits until the others leave the machine's cores nearly alone for a moment, for at most `patience` seconds."""
    end = time.perf_counter() + patience
    while time.perf_counter() < end:
        idle, start = idle_seconds(), time.perf_counter()
        time.sleep(0.25)
        if idle_seconds() - idle > 0.9 * os.cpu_count() * (time.perf_counter() - start):
            return


def idle_seconds():
    """What all cores together have idled since the start; endless where the system does not tell."""
    try:
        with open("/proc/uptime") as file:
            return float(file.read().split()[1])
    except OSError:
        return float("inf")


def interleaved(rounds, patience, programs):
    """Runs every program once, then every one again, and so on, so that a slow minute of the machine hits all alike.

    `programs` maps a name to a function that makes one run; returns the runs by name.
    """
    runs = {name: [] for name in programs}
    for _ in range(rounds):
        for name, program in programs.items():
            settle(patience)
            runs[name].append(program())
    return runs


WALL, CPU, PEAK = (lambda r: r.wall), (lambda r: r.cpu), (lambda r: r.peak)


def median(runs, what):
    return statistics.median(what(r) for r in runs)


def best(runs):
    """The fastest run's seconds: the one that was disturbed least."""
    return f"{min(r.wall for r in runs):.2f}"


def verify(raster, mesh, tolerance):
    """Judges a mesh by `terrabite verify`, which shares no code with the engines: (run, verdict)."""
    done = run(
        TERRABITE, "verify", raster, mesh, "--max-error", tolerance, "--temp-dir", WORK, "--json", may_fail=True
    )
    if not done.printed.startswith("{"):
        sys.exit(f"bench: cannot verify {mesh}: {done.printed}")
    return done, done.json()


def verified(raster, mesh, tolerance):
    """The verdict on a mesh that must be within the tolerance."""
    verdict = verify(raster, mesh, tolerance)[1]
    if not verdict["passed"]:
        sys.exit(f"bench: {mesh} of {raster} at {tolerance}: {verdict['failures']}")
    return verdict


def simplify(program, raster, mesh, tolerance, threads, options):
    """One run of a build of terrabite."""
    return run(
        program, "simplify", raster, mesh, "--max-error", tolerance, "--threads", threads, "--overwrite", "--temp-dir", WORK,
        "--json", *options,
    )


def geometric(values):
    return math.exp(sum(map(math.log, values)) / len(values))


def lists_option(command, option):
    """Whether a subcommand of terrabite has an option."""
    shown = subprocess.run([TERRABITE, command, "--help"], capture_output=True, text=True)
    return f"{option} " in shown.stdout or f"{option}\n" in shown.stdout


def print_table(header, rows):
    """Markdown, columns aligned: text to the left, numbers to the right."""
    widths = [max(len(row[i]) for row in [header, *rows]) for i in range(len(header))]
    text = [i < 2 for i in range(len(header))]

    def line(cells):
        padded = [c.ljust(w) if t else c.rjust(w) for c, w, t in zip(cells, widths, text)]
        return "| " + " | ".join(padded) + " |"

    print(line(header))
    print("|" + "|".join(":" + "-" * (w + 1) if t else "-" * (w + 1) + ":" for w, t in zip(widths, text)) + "|")
    for row in rows:
        print(line(row))
    sys.stdout.flush()


def grouped(number):
    return f"{number:,}".replace(",", " ")


def note(text):
    """Progress, apart from the table."""
    print(f"bench: {text}", file=sys.stderr, flush=True)


def machine():
    """The machine in lines, as far as it tells."""

    def first(command):
        try:
            return subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()[0].strip()
        except (OSError, subprocess.CalledProcessError, IndexError):
            return "unknown"

    def field(path, name):
        try:
            lines = Path(path).read_text().splitlines()
        except OSError:
            return "unknown"
        found = [line.split(":" if ":" in line else "=", 1)[1] for line in lines if line.startswith(name)]
        return found[0].strip().strip('"') if found else "unknown"

    memory = field("/proc/meminfo", "MemTotal").split()[0]
    memory = f"{int(memory) / MIB:.0f} GiB" if memory.isdigit() else memory
    return [
        f"CPU: {field('/proc/cpuinfo', 'model name')}, {os.cpu_count()} cores",
        f"Memory: {memory}",
        f"System: {field('/etc/os-release', 'PRETTY_NAME')}, Linux {platform.release()}, {platform.machine()}",
        f"Built with: {first(['rustc', '--version'])}; GDAL {first(['pkg-config', '--modversion', 'gdal'])}",
        f"Load before the first run: {os.getloadavg()[0]:.1f}",
    ]
