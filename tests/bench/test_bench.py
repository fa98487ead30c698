"""The benchmark measures what it says."""

import json
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import gymnasium
import mujoco
import numpy as np
import pytest

from bench import peers, rounds, single, training, vector
from bench.process import Measuring, ProcessError
from bench.rounds import ALL_CORES, CONTACT, FREE, QUICK, REACHER, Contender, Label
from prp_gym.physics.clock import clock_is_read
from prp_gym.robot.arrays import Array

_HORIZON = 50


@pytest.fixture
def env(request: pytest.FixtureRequest) -> gymnasium.Env[Any, Any]:
    return gymnasium.make(request.param, control_frequency=50, duration=_HORIZON / 50)


@pytest.mark.parametrize("env", [FREE, CONTACT], indirect=True)
def test_bare_loop_does_what_the_environment_does(
    env: gymnasium.Env[Any, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    inner: Any = env.unwrapped
    bare: list[Array] = []
    step = mujoco.mj_step

    def recorded(model: Any, data: Any, substeps: int) -> None:
        step(model, data, substeps)
        bare.append(data.qpos.copy())

    chunk = single.bare_loop(env)
    monkeypatch.setattr(mujoco, "mj_step", recorded)
    assert chunk() == len(bare)
    positions, actions = [], single.random_actions(1, 3)[:, 0]
    for index, action in enumerate(actions):
        if index % _HORIZON == 0:
            env.reset(seed=index // _HORIZON)
        env.step(action)
        positions.append(inner.physics.joint_position[0].copy())
    assert len(actions) > 2 * _HORIZON  # it has started anew
    np.testing.assert_array_equal(bare, positions)


@pytest.mark.parametrize("env", [FREE], indirect=True)
def test_environment_loop_takes_a_chunk_of_steps_with_resets(env: gymnasium.Env[Any, Any]) -> None:
    inner: Any = env.unwrapped
    chunk = single.environment_loop(env)
    steps = chunk() + 10
    for _ in range(10):
        env.step(np.zeros(3, np.float32))
    assert inner.physics.data().time == pytest.approx(steps % _HORIZON / 50)  # [s] of rounding


def test_contenders_get_the_same_actions() -> None:
    assert single.random_actions(2, 3) is single.random_actions(2, 3)
    actions = single.random_actions(2, 3)
    assert 0.9 * single.ACTION_SHARE < np.abs(actions).max() <= single.ACTION_SHARE
    assert len(np.unique(actions)) > 0.9 * actions.size  # new ones at each step and for each environment


def test_contenders_take_turns_each_with_its_own_clock() -> None:
    turns: list[tuple[str, bool, float]] = []
    closed: list[str] = []

    def contender(kind: str, clock: bool) -> Contender:
        def rate(seconds: float) -> float:
            turns.append((kind, clock_is_read(), seconds))
            return float(len(turns))

        return Contender(Label(kind, FREE, 500.0, clock=clock), rate, lambda: closed.append(kind))

    before = clock_is_read()
    results = rounds.race([contender("one", True), contender("other", False)], 2, 0.5)
    assert turns == [("one", True, 0.5), ("other", False, 0.5)] * 2
    assert [result.rates.tolist() for result in results] == [[1.0, 3.0], [2.0, 4.0]]
    assert results[0].describe()["median"] == 2.0
    assert closed == ["one", "other"]
    assert clock_is_read() == before


def test_contenders_are_ended_when_one_of_them_fails() -> None:
    closed: list[str] = []

    def fail(seconds: float) -> float:
        raise ValueError(seconds)

    label = Label("single", FREE, 500.0)
    with pytest.raises(ValueError, match=r"0\.5"):
        rounds.race([Contender(label, fail, lambda: closed.append("it"))], 1, 0.5)
    assert closed == ["it"]


def test_rate_is_steps_over_time(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = iter([10.0, 10.0, 10.4, 10.8, 11.25])
    monkeypatch.setattr(rounds, "time", SimpleNamespace(perf_counter=lambda: next(clock)))
    assert rounds.timed(lambda: 100.0)(1.0) == pytest.approx(300.0 / 1.25)  # rounding


@pytest.mark.parametrize("kind", ["native", "sync", "dummy"])
def test_episodes_are_spread_over_their_length_before_they_are_timed(kind: str) -> None:
    label, count = Label(kind, FREE, 50.0, 10), 10
    pack = vector.make_pack(label, _HORIZON / 50)
    actions = list(single.random_actions(count, 3))
    vector.stagger(pack, actions)
    outcome: Any = pack.step(actions[0])
    pack.close()
    infos = outcome[-1]
    times = [info["time"] for info in infos] if kind == "dummy" else infos["time"]
    periods = np.round(np.array(times) * 50).astype(int)
    gaps = np.diff(np.sort(periods % _HORIZON))
    assert set(gaps.tolist()) <= {_HORIZON // count, _HORIZON // count + 1}  # a call begins an episode anew


@pytest.mark.parametrize(
    ("kind", "count", "spread"),
    [("native", 8, []), ("native", 9, [9]), ("sync", 4, [4]), ("dummy", 4, [4]), ("adapter", 4, [])],
)
def test_contenders_are_spread_unless_they_run_whole_episodes(
    kind: str, count: int, spread: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    found: list[int] = []
    monkeypatch.setattr(vector, "stagger", lambda pack, actions: found.append(len(actions[0])))
    _, close = vector.step_loop(Label(kind, FREE, 50.0, count), QUICK.duration, QUICK.chunk_steps)
    close()
    assert found == spread


def test_call_that_begins_an_episode_anew_is_no_step() -> None:
    chunk, close = vector.step_loop(Label("sync", FREE, 50.0, 4), _HORIZON / 50, 256)
    assert chunk() == pytest.approx(256 * _HORIZON / (_HORIZON + 1))  # rounding
    close()


@pytest.mark.parametrize("kind", ["native", "adapter"])
def test_whole_episodes_are_run_to_their_end(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    ends: list[bool] = []
    make_pack = vector.make_pack

    def watched(label: Label, duration: float) -> vector.Pack:
        pack = make_pack(label, duration)

        def step(actions: Array) -> object:
            outcome: Any = pack.step(actions)
            ends.append(bool(np.all(outcome[3] if kind == "native" else outcome[2])))
            return outcome

        return replace(pack, step=step)

    monkeypatch.setattr(vector, "make_pack", watched)
    chunk, close = vector.step_loop(Label(kind, FREE, 50.0, 4), _HORIZON / 50, QUICK.chunk_steps)
    for _ in range(2):
        assert chunk() == pytest.approx(4 * _HORIZON)  # rounding
    close()
    assert np.flatnonzero(ends).tolist() == [_HORIZON - 1, len(ends) // 2 + _HORIZON - 1]
    assert len(ends) == 2 * (_HORIZON + (kind == "native"))


def test_single_environments_are_trained_on_one_core() -> None:
    assert {label.threads for recipe in training.RECIPES for label in training.labels(recipe, 1)} == {1}
    assert training.labels(training.RECIPES[0], 64)[-1].threads == ALL_CORES


def test_shares_of_training_are_those_of_its_time() -> None:
    recipe = training.RECIPES[0]
    one, shares = training.contender(recipe, Label("dummy", REACHER, 50.0, 2, clock=True), QUICK)
    assert one.rate(0.0) > 0.0
    one.close()
    found = shares.describe()
    assert sum(found.values()) == pytest.approx(1.0)  # rounding
    assert all(0.0 < share < 1.0 for share in found.values())


@pytest.mark.parametrize("clock", ["read", "stopped"])
def test_peer_measures_itself(clock: str) -> None:
    child = Path(peers.__file__).with_name("peer_child.py")
    process = Measuring([sys.executable, str(child), "gymnasium", REACHER, clock, "mujoco"])
    assert process.hear() == {"mujoco": mujoco.__version__}
    assert process.rate({"seconds": 0.01}) > 0.0
    process.close()


def test_process_that_ends_leaves_its_last_words() -> None:
    process = Measuring([sys.executable, "-c", "raise SystemExit('out of order')"])
    with pytest.raises(ProcessError, match="out of order"):
        process.hear()
    process.close()


def test_peers_that_are_not_installed_have_a_reason(tmp_path: Path) -> None:
    found, described = peers.contenders(tmp_path)
    assert found == []
    assert {about["reason"] for about in described} == {"not installed; see `make peers`"}


def replace_installer(monkeypatch: pytest.MonkeyPatch, run: Callable[..., None]) -> None:
    """No virtual environment is made, and pip is something else."""
    errors = {name: getattr(subprocess, name) for name in ("CalledProcessError", "TimeoutExpired")}
    monkeypatch.setattr(peers, "subprocess", SimpleNamespace(run=run, **errors))
    monkeypatch.setattr(peers, "venv", SimpleNamespace(create=lambda *arguments, **settings: None))


def test_installation_that_fails_is_kept_as_the_reason(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(command: list[str], **settings: Any) -> None:
        raise subprocess.CalledProcessError(1, command, stderr="looking\nERROR: no such version\n")

    replace_installer(monkeypatch, fail)
    assert peers.install(peers.PEERS[0], tmp_path) == "its installation failed: ERROR: no such version"
    _, described = peers.contenders(tmp_path)
    assert described[0]["reason"] == "its installation failed: ERROR: no such version"
    assert described[1]["reason"] == "not installed; see `make peers`"


def test_peer_is_installed_once_and_again_when_its_versions_change(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    commands: list[list[str]] = []
    replace_installer(monkeypatch, lambda command, **settings: commands.append(command))
    first, second = peers.PEERS
    for peer in (first, first, second):
        assert peers.install(peer, tmp_path) == ""
    assert [command[-1] for command in commands] == [first.packages[-1], second.packages[-1]]
    assert peers.install(replace(first, packages=("mujoco==1",)), tmp_path) == ""
    assert commands[-1][-1] == "mujoco==1"


def test_quick_run_measures_everything_and_writes_results_and_page(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "bench", "--quick", "--output", str(tmp_path), "--docs", str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=Path(peers.__file__).parents[1])
    assert done.returncode == 0, done.stderr
    results = json.loads((tmp_path / "bench.json").read_text(encoding="utf-8"))
    assert {"schema", "command", "versions", "machine", "effort", "goals"} <= set(results)
    assert {"processor", "cores", "load_average"} <= set(results["machine"])
    for part in ("single", "vector"):
        for row in results[part]:
            assert len(row["rates"]) == 2
            assert 0.0 <= row["lowest"] <= row["median"] <= row["highest"]  # 0 if the machine is that busy
    kinds = {row["kind"] for row in results["vector"]}
    assert kinds == {"native", "sync", "async", "dummy", "adapter", "bare_all_cores"}
    assert {row["clock"] for row in results["single"]} == {True, False}
    assert {peer["environment"] for peer in results["peers"]["peers"]} == {"FetchReach-v4", "PandaReach-v3"}
    assert {row["num_envs"] for row in results["costs"]["steps"]} == {1, QUICK.library_size}
    assert {row["control_frequency"] for row in results["costs"]["steps"]} == set(single.FREQUENCIES)
    assert results["memory"][0]["bytes_per_env"] != 0.0
    assert all(row["shares"]["train"] > 0.0 for rows in results["training"].values() for row in rows)
    assert all(goal["met"] in (True, False) for goal in results["goals"])
    assert (tmp_path / "performance.md").exists()
    assert (tmp_path / "images" / "throughput.png").exists()
    assert "single environment at 500 Hz" in done.stdout
