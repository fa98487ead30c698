"""`prp-gym view`: its page, how it ends, and what it refuses."""

import os
import re
import signal
import socket
import subprocess
import sys
import urllib.request
from importlib.util import find_spec
from typing import Any

import pytest
from typer.testing import CliRunner

import prp_gym.extras
from prp_gym.cli.main import app
from prp_gym.errors import InvalidValueError, MissingPackageError, PortError, PRPError, UnknownNameError

RUNNER = CliRunner()
FORCE = "PRP-Force-v0"
AGENT = "PRP-Force-v0/ppo_variable_force_position"

needs_viser = pytest.mark.skipif(find_spec("viser") is None, reason="the extra `view` is not installed")


def refusal(*arguments: str) -> Any:
    """The error with which the command ends."""
    return RUNNER.invoke(app, ["view", *arguments, "--web", "--port", "0"]).exception


@pytest.mark.parametrize(
    ("arguments", "kind", "text"),
    [
        (("PRP-Forse-v0",), UnknownNameError, "Did you mean 'PRP-Force-v0'"),
        ((FORCE, "--scenario", "randomised"), UnknownNameError, "Did you mean 'randomized'"),
        ((FORCE, "--baseline", "impedence"), UnknownNameError, "Did you mean 'impedance'"),
        ((FORCE, "--gains", "tunde"), UnknownNameError, "Did you mean 'tuned'"),
        ((FORCE, "--set", "bandwidth"), InvalidValueError, "--set"),
        ((FORCE, "--set", "bandwith=3"), UnknownNameError, "Did you mean 'bandwidth'"),
        ((FORCE, "--agent", AGENT, "--baseline", "impedance"), InvalidValueError, "one of the two"),
        ((FORCE, "--agent", AGENT, "--action-mode", "torque"), InvalidValueError, "variable_force_position"),
        ((FORCE, "--agent", AGENT, "--control-frequency", "500"), InvalidValueError, "Hz"),
        ((FORCE, "--agent", AGENT, "--gains", "report"), InvalidValueError, "not with --agent"),
        (("PRP-Impedance-v0", "--agent", AGENT), InvalidValueError, "environment of agent"),
        ((FORCE, "--agent", "ppo"), UnknownNameError, "agent"),
        ((FORCE, "--action-mode", "admitance"), UnknownNameError, "admittance"),
        ((FORCE, "--baseline", "impedance", "--action-mode", "admittance"), InvalidValueError, "torque"),
        ((FORCE, "--seed", "-1"), InvalidValueError, "seed"),
        ((FORCE, "--control-frequency", "50"), InvalidValueError, "unstable"),
    ],
)
def test_wrong_option_is_refused_with_what_is_allowed(
    arguments: tuple[str, ...], kind: type[PRPError], text: str
) -> None:
    error = refusal(*arguments)
    assert isinstance(error, kind)
    assert text in str(error)


def test_missing_viser_is_named_with_its_install_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(prp_gym.extras, "find_spec", lambda _: None)
    error = refusal(FORCE)
    assert isinstance(error, MissingPackageError)
    assert "pip install 'prp-gym[view]'" in str(error)


@needs_viser
@pytest.mark.parametrize("port", ["70000", "-1"])
def test_port_out_of_range_is_refused(port: str) -> None:
    error = RUNNER.invoke(app, ["view", FORCE, "--web", "--port", port]).exception
    assert isinstance(error, InvalidValueError)
    assert "at most 65535" in str(error)


@needs_viser
def test_taken_port_and_strange_host_are_refused() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = str(taken.getsockname()[1])
        error = RUNNER.invoke(app, ["view", FORCE, "--web", "--port", port]).exception
    assert isinstance(error, PortError)
    assert port in str(error)
    assert "--port" in str(error)
    strange = RUNNER.invoke(app, ["view", FORCE, "--web", "--host", "203.0.113.7"]).exception
    assert isinstance(strange, PortError)


@needs_viser
def test_interrupted_command_ends_soon_and_frees_its_port() -> None:
    command = [sys.executable, "-c", "from prp_gym.cli.main import main; main()"]
    options = ["view", "PRP-JointRegulation-v0", "--web", "--port", "0", "--scenario", "report"]
    process = subprocess.Popen(
        [*command, *options],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
    )
    try:
        assert process.stdout is not None
        line = process.stdout.readline()
        found = re.search(r"http://127\.0\.0\.1:(\d+) shows PRP-JointRegulation-v0", line)
        assert found, line
        port = int(found.group(1))
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/", timeout=10) as answer:
            assert b"<html" in answer.read().lower()
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=10)  # 1 s, and the end of a process on a busy machine
        assert process.returncode == 130
        assert "interrupted" in err
        assert "Traceback" not in out + err
        with socket.socket() as again:
            again.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            again.bind(("127.0.0.1", port))
    finally:
        process.kill()
        process.wait(10)
