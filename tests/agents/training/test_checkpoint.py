"""Runs that go on after an interruption, and the checkpoints from which they do."""

import os
import pickle
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from prp_gym.agents.algorithms import ALGORITHMS
from prp_gym.agents.training import checkpoint
from prp_gym.agents.training.checkpoint import find_checkpoint, restore_checkpoint, write_checkpoint
from prp_gym.agents.training.model import make_learner
from prp_gym.agents.training.run_folder import RunFolder
from prp_gym.agents.training.train import train
from prp_gym.agents.training.training_state import TrainingState
from prp_gym.errors import CheckpointError, FolderInUseError, OutputError, RunFolderError
from tests.support.full_disk import room_for
from tests.support.training_runs import (
    assert_equal,
    assert_same_weights,
    interrupted,
    read,
    tiny_job,
    tiny_recipe,
    trained,
)


def test_of_two_checkpoints_the_newer_is_found(tmp_path: Path) -> None:
    """Where a run was killed after it wrote one and before it removed the other."""
    for steps in (96, 1024, 128):
        (tmp_path / f"checkpoint-{steps:012d}").mkdir()
    assert [path.name for path in find_checkpoint(tmp_path)] == ["checkpoint-000000001024"]


@pytest.mark.parametrize("algorithm", ["ppo", "sac"])  # one on its last episodes, one with a replay buffer
def test_interrupted_run_goes_on_to_the_same_number_of_steps(tmp_path: Path, algorithm: str) -> None:
    whole = train(tiny_job(tmp_path / "whole", algorithm))
    job = tiny_job(tmp_path / "run", algorithm)
    with pytest.raises(KeyboardInterrupt):
        train(job, interrupted(3))
    before = read(job.folder / "curve.json")["rows"]
    with pytest.raises(RunFolderError, match="--resume"):
        train(job)
    result = train(replace(job, existing="resume"))
    rows = read(job.folder / "curve.json")["rows"]
    assert (result["steps"], result["resumes"]) == (whole["steps"], 1)
    assert rows[:2] == before[:2]  # the third evaluation was after the last checkpoint, and is made again
    assert [row["steps"] for row in rows] == [
        row["steps"] for row in read(tmp_path / "whole" / "curve.json")["rows"]
    ]
    assert rows[2]["seconds"] > rows[1]["seconds"]
    assert rows[2]["violations"]["joint_stop"] >= rows[1]["violations"]["joint_stop"]


def test_run_interrupted_before_its_first_checkpoint_begins_again(tmp_path: Path) -> None:
    whole = train(tiny_job(tmp_path / "whole"))
    job = tiny_job(tmp_path / "run")
    with pytest.raises(KeyboardInterrupt):
        train(job, interrupted(1))
    assert find_checkpoint(job.folder) == []
    assert train(replace(job, existing="resume"))["best"] == whole["best"]
    assert_same_weights(job.folder, tmp_path / "whole")


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"more": ["batch_size=32"]}, "batch_size is 64 there and 32 here"),
        ({"more": ["env_kwargs.duration=2"]}, "env_kwargs.duration is 1 there and 2 here"),
        ({"more": ["ent_coef=0.1"]}, "ent_coef is None there and 0.1 here"),
        ({"eval_episodes": 5}, "eval_episodes is 4 there and 5 here"),
        ({"seed": 1}, "seed is 0 there and 1 here"),
    ],
)
@pytest.mark.parametrize("existing", ["refuse", "resume"])
def test_going_on_with_other_settings_is_refused_and_the_difference_told(
    begun: Path, change: dict[str, Any], told: str, existing: str
) -> None:
    with pytest.raises(RunFolderError) as caught:
        train(tiny_job(begun, existing=existing, **change))
    assert caught.value.reason == f"it was trained with other settings: {told}"


@pytest.fixture(scope="module")
def begun(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a run of PPO that was interrupted after its second checkpoint."""
    folder = tmp_path_factory.mktemp("begun") / "run"
    with pytest.raises(KeyboardInterrupt):
        train(tiny_job(folder), interrupted(3))
    return folder


def test_two_processes_do_not_train_in_one_folder(tmp_path: Path) -> None:
    job = tiny_job(tmp_path / "run")
    with RunFolder(job.folder).hold(), pytest.raises(FolderInUseError) as caught:
        train(job)
    assert f"is in use by process {os.getpid()} on " in str(caught.value)
    assert "--fresh" not in str(caught.value)
    assert train(job)["steps"] == 512
    assert not list(job.folder.glob(".*"))


DAMAGES = {
    "state.json": [b"", b'{"a', b"12\n{}\n"],
    "tensors.pt": [b"", b"PK"],
    "arrays.npz": [b"", b"PK"],
}


@pytest.mark.parametrize(("name", "content"), [(k, v) for k, values in DAMAGES.items() for v in values])
def test_damaged_checkpoint_is_refused_with_its_name(
    tmp_path: Path, begun: Path, name: str, content: bytes
) -> None:
    shutil.copytree(begun, tmp_path / "run")
    checkpoint = find_checkpoint(tmp_path / "run")[0]
    (checkpoint / name).write_bytes(content)
    with pytest.raises(CheckpointError, match="--fresh starts over") as caught:
        train(tiny_job(tmp_path / "run", existing="resume"))
    assert caught.value.path == str(checkpoint)


@pytest.mark.parametrize("name", DAMAGES)
def test_changed_byte_or_missing_file_is_noticed(tmp_path: Path, begun: Path, name: str) -> None:
    shutil.copytree(begun, tmp_path / "run")
    path = find_checkpoint(tmp_path / "run")[0] / name
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)
    with pytest.raises(CheckpointError):
        train(tiny_job(tmp_path / "run", existing="resume"))
    path.unlink()
    with pytest.raises(CheckpointError):
        train(tiny_job(tmp_path / "run", existing="resume"))


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_restored_learner_is_the_one_that_was_kept(tmp_path: Path, algorithm: str) -> None:
    learner, state = trained(algorithm)
    write_checkpoint(tmp_path, learner, state)
    model: Any = learner.model
    drawn = (np.random.random(), torch.rand(()).item(), model.action_space.sample())  # noqa: NPY002
    fresh = make_learner(tiny_recipe(algorithm), 7)
    other: Any = fresh.model
    restored = restore_checkpoint(find_checkpoint(tmp_path)[0], fresh)
    assert_equal(other.get_parameters(), model.get_parameters())
    for name in ("num_timesteps", "_n_updates", "_episode_num"):
        assert getattr(other, name) == getattr(model, name) > 0 or name == "_episode_num"
    for name in model._get_torch_save_params()[1]:
        assert torch.equal(getattr(other, name), getattr(model, name))
    for name in ("obs_rms", "ret_rms"):
        assert_equal(vars(getattr(fresh.env, name)), vars(getattr(learner.env, name)))
    if getattr(model, "replay_buffer", None) is not None:
        assert other.replay_buffer.pos == model.replay_buffer.pos > 0
        for name in ("observations", "next_observations", "actions", "rewards", "dones", "timeouts"):
            assert_equal(getattr(other.replay_buffer, name), getattr(model.replay_buffer, name))
    assert_equal(drawn, (np.random.random(), torch.rand(()).item(), other.action_space.sample()))  # noqa: NPY002
    assert restored.curve == state.curve
    assert restored.violations == state.violations
    assert (restored.seconds, restored.evaluation_seconds, restored.resumes) == (2.5, 0.5, 4)
    assert_equal(restored.best[0].weights, dict(state.best[0].weights))
    assert_equal(vars(restored.best[0].normalizer), vars(state.best[0].normalizer))
    assert (restored.best[0].steps, restored.best[0].score) == (128, 0.5)


def test_replay_buffer_that_has_gone_round_is_restored_whole(tmp_path: Path) -> None:
    recipe = tiny_recipe("sac", ["buffer_size=100", "learning_starts=10000"])
    learner = make_learner(recipe, 0)
    learner.model.learn(256)
    write_checkpoint(tmp_path, learner, TrainingState())
    fresh = make_learner(recipe, 1)
    restore_checkpoint(find_checkpoint(tmp_path)[0], fresh)
    ours: Any = fresh.model
    theirs: Any = learner.model
    assert ours.replay_buffer.full
    assert ours.replay_buffer.pos == theirs.replay_buffer.pos
    np.testing.assert_array_equal(ours.replay_buffer.observations, theirs.replay_buffer.observations)


def test_only_the_newest_checkpoint_is_kept_and_half_a_one_does_not_count(tmp_path: Path) -> None:
    learner, state = trained("ppo")
    write_checkpoint(tmp_path, learner, state)
    learner.model.num_timesteps += 64
    write_checkpoint(tmp_path, learner, state)
    half = tmp_path / ".checkpoint-000000000999.part"
    half.mkdir()
    assert [path.name for path in tmp_path.glob("checkpoint-*")] == ["checkpoint-000000000320"]
    assert find_checkpoint(tmp_path)[0].name == "checkpoint-000000000320"


@pytest.mark.parametrize("algorithm", ["ppo", "sac"])
@pytest.mark.parametrize("room", [0, 1000, 6000])
def test_full_disk_leaves_the_previous_checkpoint(tmp_path: Path, algorithm: str, room: int) -> None:
    learner, state = trained(algorithm)
    write_checkpoint(tmp_path, learner, state)
    before = find_checkpoint(tmp_path)
    learner.model.num_timesteps += 64
    with room_for(room), pytest.raises(OutputError) as caught:
        write_checkpoint(tmp_path, learner, state)
    assert caught.value.path == str(tmp_path / f"checkpoint-{learner.model.num_timesteps:012d}")
    assert list(tmp_path.iterdir()) == before
    restore_checkpoint(before[0], learner)


@pytest.mark.parametrize("tensorboard", [False, True])
def test_disk_that_gets_full_in_training_ends_it_and_it_goes_on_later(
    tmp_path: Path, tensorboard: bool
) -> None:
    job = tiny_job(tmp_path / "run", tensorboard=tensorboard)
    with room_for(3000), pytest.raises(OutputError, match="File too large"):
        train(job)
    assert not [path for path in job.folder.rglob("*") if path.name.startswith(".")]
    assert train(replace(job, existing="resume"))["steps"] == 512


def test_folder_removed_in_training_ends_it_and_is_not_made_again(tmp_path: Path) -> None:
    job = tiny_job(tmp_path / "run")
    with pytest.raises(OutputError, match="the folder was removed or renamed during the run"):
        train(job, lambda _: shutil.rmtree(job.folder))
    assert not job.folder.exists()


def test_incomplete_checkpoint_of_a_killed_run_is_removed_by_the_next(tmp_path: Path) -> None:
    (tmp_path / "run" / ".checkpoint-000000000999.part").mkdir(parents=True)
    (tmp_path / "run" / ".lock").write_text("left by a killed process")
    with pytest.raises(KeyboardInterrupt):
        train(tiny_job(tmp_path / "run"), interrupted(1))
    assert not list((tmp_path / "run").glob(".*"))


class Trap:
    """What runs code when it is unpickled."""

    def __reduce__(self) -> tuple[Any, ...]:
        return (Path.touch, (Path("sprung"),))


def test_code_in_a_checkpoint_is_not_run(
    tmp_path: Path, begun: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(checkpoint, "_checksum", lambda path: 0)  # as if an attacker had adapted the checksum
    learner, state = trained("ppo")
    write_checkpoint(tmp_path, learner, state)
    there = find_checkpoint(tmp_path)[0]
    torch.save({"parameters": Trap()}, there / "tensors.pt")
    with pytest.raises(CheckpointError, match="Weights only load failed"):
        restore_checkpoint(there, learner)
    (tmp_path / "second").mkdir()
    write_checkpoint(tmp_path / "second", learner, state)
    there = find_checkpoint(tmp_path / "second")[0]
    (there / "arrays.npz").write_bytes(pickle.dumps(Trap()))
    with pytest.raises(CheckpointError, match="is not an archive of arrays"):
        restore_checkpoint(there, learner)
    assert not Path("sprung").exists()
