"""Makes a run that ``terrabite plan`` has laid out on a Dask cluster, and puts the mesh together.

    python -m terrabite.dask WORK OUTPUT --scheduler tcp://HOST:8786 --shards 64

Each worker starts the command ``terrabite run`` for one shard of one pass at a time. The folder WORK is shared by all machines, and
so is the raster. Needs ``distributed``, which ``pip install distributed`` brings.
"""

from __future__ import annotations

import argparse
import importlib
import json
import os
import shlex
import socket
import subprocess
import sys
import time
import uuid
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

__all__ = ["ShardError", "main", "run"]

# What `terrabite merge` ends with where passes have to be made first.
WAITING = 6
# Seconds between two looks at a process, and at whether the run was stopped.
LOOK = 0.5


class ShardError(RuntimeError):
    """A shard that could not be made: which, why, and where its log is."""


@dataclass(frozen=True)
class Task:
    """A shard of a pass, and how it is made."""

    work: str
    shard: int
    shards: int
    # From 1.
    number: int
    command: str
    options: tuple[str, ...]
    program: str
    stop: str

    def __str__(self) -> str:
        return f"shard {self.shard}/{self.shards} of pass {self.number}"

    def words(self) -> list[str]:
        return [self.command, "run", self.work, "--shard", f"{self.shard}/{self.shards}", "--pass", str(self.number), *self.options]


def run(
    work: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    scheduler: str,
    shards: int,
    command: str = "terrabite",
    options: Sequence[str] = (),
    merge_options: Sequence[str] = (),
    retries: int = 3,
    in_flight: int | None = None,
    tell: Callable[[str], None] = lambda line: None,
) -> None:
    """Makes all shards of all passes on the workers of a scheduler, then puts the mesh together on this machine.

    ``options`` go to every ``terrabite run`` (such as ``--memory 4GiB``), ``merge_options`` to ``terrabite merge``; ``command`` is the
    program, here and on every worker. A shard that fails, or whose worker is lost, is tried ``retries`` times more. At most
    ``in_flight`` shards are with the scheduler at a time (two for each thread of the workers, if not given). ``tell`` is told how far
    it has come.

    Raises ShardError where a shard or the merge fails for good, ValueError for what makes no sense, FileNotFoundError where no run
    is laid out in ``work``. Stopped by KeyboardInterrupt, it stops the processes on the workers; finished tiles are kept.
    """
    dask = _distributed()
    if shards < 1:
        raise ValueError(f"shards: expected 1 or more, found {shards}")
    if in_flight is not None and in_flight < 1:
        raise ValueError(f"in_flight: expected 1 or more, found {in_flight}")
    if isinstance(options, str) or isinstance(merge_options, str):
        raise TypeError("options: expected a sequence of words, found text")
    folder = Path(work).absolute()
    plan = _plan(folder)
    (folder / "logs").mkdir(exist_ok=True)
    _must_be(command, plan["program"], "here")
    stop = f"terrabite-stop-{uuid.uuid4()}"
    make = _tasks(folder, shards, command, tuple(options), plan["program"], stop)
    merge = [command, "merge", str(folder), str(output), "--quiet", *merge_options]
    with dask.Client(scheduler, set_as_default=False) as client:
        event = dask.Event(stop, client=client)
        try:
            passes, last = range(1, plan["passes"] + 1), plan["passes"]
            while True:
                tried = _tolerance(folder)
                for number in passes:
                    _make_pass(client, make(number), number, last, retries, in_flight, tell)
                tell("merging")
                merged = subprocess.run(merge, capture_output=True, text=True, check=False)
                if merged.returncode != WAITING:
                    break
                if (following := _tolerance(folder)) != tried:
                    # A budget: the next run of the search.
                    passes, last = range(1, plan["passes"] + 1), plan["passes"]
                    tell(f"the search goes on at the tolerance of {following}")
                elif last == plan["passes"] and (folder / "short-links").exists():
                    # Seldom: some edges would stray too far beside long links between tiles.
                    passes, last = range(plan["passes"] + 1, 2 * plan["passes"] + 1), 2 * plan["passes"]
                else:
                    break
        except BaseException:
            event.set()
            raise
    if merged.returncode != 0:
        raise ShardError(f"{shlex.join(merge)}: {_reason(merged.stderr, merged.returncode)}")


def _distributed() -> Any:
    """Dask's library, which has no types."""
    try:
        return importlib.import_module("distributed")
    except ImportError as error:
        raise ImportError("terrabite.dask needs distributed: pip install distributed") from error


def _plan(folder: Path) -> dict[str, Any]:
    path = folder / "plan.json"
    if not path.is_file():
        raise FileNotFoundError(f"{folder}: expected a folder in which a run is laid out; terrabite plan does so")
    plan = json.loads(path.read_text())
    if not isinstance(plan, dict) or not isinstance(plan.get("passes"), int) or not isinstance(plan.get("program"), str):
        raise ValueError(f"{path}: expected the plan of a run, found something else")
    return plan


def _tolerance(folder: Path) -> float | None:
    """Where a budget is met by a search: the tolerance of the run that is being made."""
    path = folder / "tolerance"
    return float(path.read_text()) if path.is_file() else None


def _tasks(
    folder: Path, shards: int, command: str, options: tuple[str, ...], program: str, stop: str
) -> Callable[[int], Iterator[Task]]:
    def of_pass(number: int) -> Iterator[Task]:
        for shard in range(1, shards + 1):
            yield Task(str(folder), shard, shards, number, command, options, program, stop)

    return of_pass


def _make_pass(
    client: Any,
    tasks: Iterator[Task],
    number: int,
    passes: int,
    retries: int,
    in_flight: int | None,
    tell: Callable[[str], None],
) -> None:
    """All shards of a pass, of which a bounded number is with the scheduler at a time."""
    bound = in_flight or 2 * max(1, sum(client.nthreads().values()))

    def submit(task: Task) -> Any:
        return client.submit(_make, task, key=f"terrabite-{uuid.uuid4()}", retries=retries, pure=False)

    first = [submit(task) for _, task in zip(range(bound), tasks, strict=False)]
    waiting, done = _distributed().as_completed(first, loop=client.loop), 0
    for future in waiting:
        # Raises what the shard has raised.
        future.result()
        future.release()
        done += 1
        tell(f"pass {number} of {passes}: {done} shards done")
        following = next(tasks, None)
        if following is not None:
            waiting.add(submit(following))


def _make(task: Task) -> None:
    """Makes a shard of a pass: on a worker."""
    dask = _distributed()
    _must_be(task.command, task.program, f"on {socket.gethostname()}")
    words = task.words()
    if "--threads" not in words:
        threads = max(1, (os.cpu_count() or 1) // max(1, dask.get_worker().state.nthreads))
        words += ["--threads", str(threads)]
    log = Path(task.work) / "logs" / f"pass-{task.number}-shard-{task.shard}-of-{task.shards}.log"
    with open(log, "a") as said:
        print(f"{socket.gethostname()}: {shlex.join(words)}", file=said, flush=True)
        code = _finished(words, said, dask.Event(task.stop))
    if code != 0:
        raise ShardError(f"{task}: {_reason(log.read_text(), code)}; its log is {log}")


def _finished(words: Sequence[str], said: IO[str], stop: Any) -> int:
    """Runs a process to its end, or until the run is stopped."""
    with subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=said, stderr=said) as process:
        while True:
            try:
                return process.wait(LOOK)
            except subprocess.TimeoutExpired:
                if stop.is_set():
                    process.terminate()


def _must_be(command: str, program: str, where: str) -> None:
    """Refuses a command that is not of the version that laid the run out."""
    try:
        found = subprocess.run([command, "-V"], capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError) as error:
        raise ShardError(f"{command}: expected {program} {where}, found no command that runs ({error}); --command names it") from error
    if found != program:
        raise ShardError(f"{command}: expected {program}, which laid the run out, found {found} {where}")


def _reason(said: str, code: int) -> str:
    """What a process says of its failure, or how it ended."""
    if code == WAITING:
        return "it waits for chunks of the pass before, which have been lost"
    errors = [line for line in said.splitlines() if line.startswith("error:")]
    return errors[-1] if errors else f"exit code {code}"


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; gives its exit code."""
    parser = argparse.ArgumentParser(prog="python -m terrabite.dask", description=(__doc__ or "").splitlines()[0])
    parser.add_argument("work", metavar="WORK", help="the folder in which terrabite plan has laid the run out")
    parser.add_argument("output", metavar="OUTPUT", help="the mesh")
    parser.add_argument("--scheduler", required=True, metavar="ADDRESS", help="such as tcp://HOST:8786")
    parser.add_argument("--shards", required=True, type=int, metavar="N", help="parts of every pass; several for each worker")
    parser.add_argument("--command", default="terrabite", metavar="PATH", help="the command, here and on every worker")
    parser.add_argument("--retries", type=int, default=3, metavar="N", help="how often a shard that fails is tried again [default: 3]")
    parser.add_argument("--memory", metavar="BYTES", help="the most memory for each process, such as 4GiB")
    parser.add_argument("--threads", metavar="N", help="threads of each process [default: the worker's share of its machine]")
    parser.add_argument("--overwrite", action="store_true", help="replace an existing output")
    parser.add_argument("--keep-work-dir", action="store_true", help="keep WORK when the mesh is there")
    parser.add_argument("--quiet", "-q", action="store_true", help="print nothing but errors")
    asked = parser.parse_args(arguments)
    machine = [word for name in ("memory", "threads") if getattr(asked, name) for word in (f"--{name}", getattr(asked, name))]
    merging = [f"--{name.replace('_', '-')}" for name in ("overwrite", "keep_work_dir") if getattr(asked, name)]
    tell = (lambda line: None) if asked.quiet else _lines()
    try:
        run(
            asked.work,
            asked.output,
            scheduler=asked.scheduler,
            shards=asked.shards,
            command=asked.command,
            options=machine,
            merge_options=[*merging, *machine],
            retries=asked.retries,
            tell=tell,
        )
    except KeyboardInterrupt:
        print("stopped; finished tiles are kept", file=sys.stderr)
        return 130
    except (ShardError, ImportError, OSError, ValueError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    return 0


def _lines() -> Callable[[str], None]:
    """Prints what is told, at most one line a second of each pass."""
    last = 0.0

    def tell(line: str) -> None:
        nonlocal last
        if not line.startswith("pass") or time.monotonic() - last >= 1:
            print(line, file=sys.stderr, flush=True)
            last = time.monotonic()

    return tell


if __name__ == "__main__":
    sys.exit(main())
