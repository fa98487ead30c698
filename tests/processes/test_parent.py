"""A worker ends with its parent, also with one that is killed or has ended before the worker looks."""

import os
import subprocess
import sys
import time

import pytest

PARENT = """
import os, subprocess, sys
worker = '''
import os, sys, time
from prp_gym.processes import parent
if sys.argv[2] == "poll":
    del os.pidfd_open
if sys.argv[3] == "late":
    time.sleep(0.5)
parent.end_with_parent(int(sys.argv[1]))
while True:
    time.sleep(60)
'''
child = subprocess.Popen([sys.executable, "-c", worker, str(os.getpid()), *sys.argv[1:]])
print(child.pid, flush=True)
if sys.argv[2] == "late":
    os._exit(0)
sys.stdin.read()
"""


def is_alive(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return True


@pytest.mark.parametrize("way", ["wait", "poll"])
@pytest.mark.parametrize("moment", ["early", "late"])
def test_worker_ends_with_its_parent(way: str, moment: str) -> None:
    command = [sys.executable, "-c", PARENT, way, moment]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as parent:
        assert parent.stdout is not None
        worker = int(parent.stdout.readline())
        assert is_alive(worker)
        parent.kill()
        parent.wait()
    end = time.monotonic() + 30.0  # s, on a busy machine; alone it takes the time of an import
    while is_alive(worker) and time.monotonic() < end:
        time.sleep(0.02)
    assert not is_alive(worker)
