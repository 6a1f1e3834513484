"""Progress, the cancel flag, Ctrl-C, exceptions of callbacks."""

from __future__ import annotations

import signal
import subprocess
import sys
import textwrap
import threading
import time

import numpy as np
import pytest
import terrabite as tb
from conftest import hills

#: Seconds in which a call stops: it takes a fraction of one, and the machine may be busy with other tests.
SOON = 4

#: Takes a minute where it is not stopped.
ENDLESS = """
import signal
import numpy as np
import terrabite as tb
# What runs in the background of a shell ignores it.
signal.signal(signal.SIGINT, signal.default_int_handler)
rough = np.random.default_rng(1).random((3000, 3000), dtype="float32")
"""


def rough() -> np.ndarray:
    return np.random.default_rng(1).random((3000, 3000), dtype="float32")


def test_progress_is_told_by_the_calling_thread():
    told = []
    tb.simplify(hills(300, 400), 2, tile=100, progress=lambda *state: told.append((threading.get_ident(), *state)))
    assert {thread for thread, *_ in told} == {threading.get_ident()}
    stages = {stage for _, stage, _, _ in told}
    assert {"triangulate", "write"} <= stages
    last = {stage: (done, total) for _, stage, done, total in told}
    assert all(done == total > 0 for done, total in last.values()), last
    assert all(0 <= done <= total for _, _, done, total in told)


def test_the_flag_stops_a_call_within_a_second():
    flag, at = threading.Event(), []
    threading.Timer(0.5, lambda: (at.append(time.monotonic()), flag.set())).start()
    with pytest.raises(tb.Cancelled):
        tb.simplify(rough(), 0.01, cancel=flag)
    assert time.monotonic() - at[0] < SOON


def test_a_flag_that_is_set_already_stops_before_the_beginning(dem):
    flag = threading.Event()
    flag.set()
    with pytest.raises(tb.Cancelled):
        tb.simplify(dem, 1, cancel=flag)
    with pytest.raises(tb.Cancelled):
        tb.verify(dem, tb.simplify(dem, 1), 1, cancel=flag)
    with pytest.raises(tb.Cancelled):
        tb.simplify(dem, 1).write("never.ply", cancel=flag)


def test_what_a_callback_raises_ends_the_call():
    def fails(stage: str, done: int, total: int) -> None:
        raise KeyError(stage)

    begun = time.monotonic()
    with pytest.raises(KeyError):
        tb.simplify(rough(), 0.01, progress=fails)
    assert time.monotonic() - begun < SOON


def interrupted(script: str) -> tuple[float, int, str]:
    """How long a script goes on after Ctrl-C, how it ends, and what it prints."""
    # Without the folder of the sources on its path.
    command = [sys.executable, "-P", "-c", ENDLESS + textwrap.dedent(script)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as child:
        try:
            assert child.stdout is not None and child.stdout.readline() == "begun\n"
            time.sleep(0.5)
            sent = time.monotonic()
            child.send_signal(signal.SIGINT)
            printed, _ = child.communicate(timeout=60)
            return time.monotonic() - sent, child.returncode, printed
        finally:
            child.kill()


def test_ctrl_c_stops_a_call_of_the_main_thread():
    took, code, printed = interrupted("print('begun', flush=True)\ntb.simplify(rough, 0.01)")
    assert took < SOON and code != 0 and "KeyboardInterrupt" in printed


def test_ctrl_c_stops_a_call_of_a_worker_by_the_flag():
    took, code, printed = interrupted(
        """
        import threading
        flag, ended = threading.Event(), threading.Event()
        def work():
            try:
                tb.simplify(rough, 0.01, cancel=flag)
            except tb.Cancelled:
                print("cancelled")
            ended.set()
        threading.Thread(target=work).start()
        print('begun', flush=True)
        try:
            ended.wait()
        except KeyboardInterrupt:
            flag.set()
            ended.wait()
        """
    )
    assert took < SOON and code == 0 and "cancelled" in printed


def test_a_call_goes_on_in_its_work_dir(tmp_path):
    heights, flag, options = hills(300, 400), threading.Event(), {"tile": 64, "work_dir": tmp_path / "work"}

    def stop(stage: str, done: int, total: int) -> None:
        if stage == "triangulate" and 0 < done < total:
            flag.set()

    with pytest.raises(tb.Cancelled):
        tb.simplify(np.tile(heights, (4, 4)), 0.01, cancel=flag, progress=stop, **options)
    with pytest.raises(tb.Error):
        tb.simplify(heights, 2, **options)
    tin = tb.simplify(np.tile(heights, (4, 4)), 0.01, **options)
    assert tin.report["tiles_found"] > 0 and not (tmp_path / "work").exists()
    tin = tb.simplify(heights, 2, keep_work_dir=True, **options)
    assert (tmp_path / "work").is_dir()
    again = tb.simplify(heights, 2, **options)
    assert np.array_equal(again.vertices, tin.vertices) and np.array_equal(again.triangles, tin.triangles)
