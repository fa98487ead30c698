"""The window of render mode `human`, on a virtual display."""

import shutil
import subprocess
import sys

import pytest

CODE = """
import gymnasium, prp_gym
env = gymnasium.make("PRP-JointTracking-v0", render_mode="human", control_frequency=50)
env.reset(seed=0)
for _ in range(5):
    env.step(env.action_space.sample())
env.close()
print("closed")
"""


@pytest.mark.skipif(shutil.which("xvfb-run") is None, reason="needs a virtual display (Debian: xvfb)")
def test_window_opens_follows_and_closes() -> None:
    command = ["xvfb-run", "--auto-servernum", sys.executable, "-c", CODE]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert (done.returncode, done.stdout.strip()) == (0, "closed"), done.stderr
