"""A run in shards on a Dask cluster of this machine: a worker is killed, and the bytes are those of `simplify`."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
import terrabite.dask as tb_dask
from conftest import run

OPTIONS = ["--max-error", "2", "--tile", "64"]


class Cluster:
    """A scheduler and workers on loopback."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.file = folder, folder / "scheduler.json"
        self.scheduler = self.start("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--no-show")
        self.workers = [self.start("worker", "--host", "127.0.0.1", "--no-nanny", "--nthreads", "1", "--no-dashboard") for _ in range(2)]
        from distributed import Client

        with Client(scheduler_file=str(self.file), set_as_default=False) as client:
            client.wait_for_workers(2, timeout=60)
            self.address = client.scheduler.address

    def start(self, *words: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", "distributed.cli.dask_" + words[0], "--scheduler-file", str(self.file), *words[1:]]
        with open(self.folder / f"{words[0]}.log", "ab") as log:
            return subprocess.Popen(command, cwd=self.folder, stdout=log, stderr=log)

    def stop(self) -> None:
        for process in [*self.workers, self.scheduler]:
            process.kill()
            process.wait()


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[Cluster]:
    folder = tmp_path / "cluster"
    folder.mkdir()
    cluster = Cluster(folder)
    yield cluster
    cluster.stop()


def test_a_worker_is_killed_and_the_bytes_are_the_same(command: Path, tmp_path: Path, cluster: Cluster) -> None:
    dem, work, output, expected = (tmp_path / name for name in ("dem.tif", "work", "tin.ply", "expected.ply"))
    run(command, "synth", dem, "--size", "513x400", "--seed", "3")
    run(command, "simplify", dem, expected, *OPTIONS)
    run(command, "plan", dem, work, *OPTIONS)
    said: list[str] = []

    def tell(line: str) -> None:
        if not said:
            os.kill(cluster.workers[0].pid, signal.SIGKILL)
        said.append(line)

    tb_dask.run(work, output, scheduler=cluster.address, shards=5, command=str(command), tell=tell)
    assert output.read_bytes() == expected.read_bytes()
    assert cluster.workers[0].poll() == -signal.SIGKILL and cluster.workers[1].poll() is None
    assert said[-1] == "merging" and "pass 4 of 4: 5 shards done" in said
    assert not work.exists()

    # A budget, which takes several runs.
    budget = ["--max-triangles", "1500", "--quality", "fast", "--tile", "128", "--overwrite", "--quiet"]
    run(command, "simplify", dem, expected, *budget)
    run(command, "plan", dem, work, *(word for word in budget if word != "--overwrite"))
    said.clear()
    tb_dask.run(work, output, scheduler=cluster.address, shards=2, command=str(command), merge_options=["--overwrite"], tell=said.append)
    assert output.read_bytes() == expected.read_bytes()
    assert any("the search goes on at the tolerance of" in line for line in said)

    # A shard that cannot be made, and a command of another version.
    run(command, "plan", dem, work, *OPTIONS)
    dem.rename(tmp_path / "elsewhere.tif")
    with pytest.raises(tb_dask.ShardError, match=r"shard \d/2 of pass 1: error: .*dem.tif.*; its log is .*/logs/pass-1-shard-\d-of-2.log"):
        tb_dask.run(work, output, scheduler=cluster.address, shards=2, command=str(command), retries=1)
    other = tmp_path / "other"
    other.write_text("#!/bin/sh\necho terrabite 0.0.1\n")
    other.chmod(0o755)
    with pytest.raises(tb_dask.ShardError, match="which laid the run out, found terrabite 0.0.1 here"):
        tb_dask.run(work, output, scheduler=cluster.address, shards=2, command=str(other))


def test_what_makes_no_sense_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = [str(tmp_path), "tin.ply", "--scheduler", "tcp://127.0.0.1:1", "--shards"]
    assert tb_dask.main([*words, "2"]) == 1
    assert "terrabite plan does so" in capsys.readouterr().err
    assert tb_dask.main([*words, "0"]) == 1
    assert "expected 1 or more, found 0" in capsys.readouterr().err
    (tmp_path / "plan.json").write_text("[]")
    assert tb_dask.main([*words, "2"]) == 1
    assert "expected the plan of a run" in capsys.readouterr().err
    with pytest.raises(TypeError, match="sequence of words"):
        tb_dask.run(tmp_path, "tin.ply", scheduler="tcp://127.0.0.1:1", shards=1, options="--memory 1GiB")


def test_stopping_ends_the_processes(command: Path, tmp_path: Path, cluster: Cluster) -> None:
    work = tmp_path / "work"
    (tmp_path / "work" / "logs").mkdir(parents=True)
    slow = tmp_path / "slow"
    version = run(command, "-V").strip()
    slow.write_text(f'#!/bin/sh\n[ "$1" = -V ] && echo "{version}" || exec sleep 600\n')
    slow.chmod(0o755)
    (work / "plan.json").write_text(f'{{"program": "{version}", "passes": 1, "words": [], "folder": "/"}}')
    words = [str(work), "tin.ply", "--scheduler", cluster.address, "--shards", "1", "--command", str(slow)]
    # What runs in the background of a shell ignores interrupts, and so do its children.
    listens = "import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler)"
    program = f"{listens}; from terrabite.dask import main; sys.exit(main())"
    process = subprocess.Popen([sys.executable, "-c", program, *words], cwd=tmp_path, stderr=subprocess.PIPE, text=True)
    log = work / "logs" / "pass-1-shard-1-of-1.log"
    while not log.exists():
        assert process.poll() is None, process.communicate()
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=20)
    assert process.returncode == 130 and "finished tiles are kept" in said
    deadline = time.monotonic() + 10
    while "sleep 600" in subprocess.run(["ps", "-eo", "args"], capture_output=True, text=True, check=True).stdout:
        assert time.monotonic() < deadline, "the process of the shard goes on"
        time.sleep(0.1)
