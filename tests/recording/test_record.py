"""The command `prp-gym record`: what its videos show, and what it refuses."""

import itertools
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image
from typer.testing import CliRunner

import prp_gym.extras
import prp_gym.recording.composer
from prp_gym.cli.main import app
from prp_gym.errors import (
    InvalidValueError,
    MissingPackageError,
    OutputError,
    PRPError,
    UnknownNameError,
)
from prp_gym.processes.leftovers import part_of

FORCE = "PRP-Force-v0"
SHORT = ("--duration", "0.4", "--fps", "10", "--size", "192x144", "--scenario", "report")
CONTROLLER = ("--baseline", "force_inner_position")


def record(*arguments: str) -> str:
    """Run the command; its output. Errors of the package are raised."""
    done = CliRunner().invoke(app, ["record", *arguments])
    if isinstance(done.exception, PRPError):
        raise done.exception
    assert done.exit_code == 0, done.output
    return done.output


def frames_of(folder: Path) -> list[NDArray[np.uint8]]:
    """The frames of a folder in their order."""
    return [np.asarray(Image.open(path)) for path in sorted(folder.iterdir())]


@pytest.fixture
def lines(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The lines of numbers that a recording writes into its frames."""
    written: list[str] = []
    numbers = prp_gym.recording.composer.numbers

    def noted(side: Any) -> str:
        written.append(f"{side.name}: {numbers(side)}")
        return numbers(side)

    monkeypatch.setattr(prp_gym.recording.composer, "numbers", noted)
    return written


@pytest.mark.filterwarnings(
    "ignore::pytest.PytestUnraisableExceptionWarning"
)  # imageio-ffmpeg leaves pipes open
def test_mp4_has_the_size_the_rate_and_a_frame_for_every_moment(open_contexts: None, tmp_path: Path) -> None:
    imageio_ffmpeg = pytest.importorskip("imageio_ffmpeg")
    path = tmp_path / "new folder" / "force.mp4"
    output = record(FORCE, *CONTROLLER, *SHORT, "--output", str(path))
    reader = imageio_ffmpeg.read_frames(str(path))
    facts = next(reader)
    assert facts["size"] == (192, 144)
    assert facts["fps"] == 10.0
    assert len(list(reader)) == 5  # at 0, 0.1, 0.2, 0.3 and 0.4 s
    assert facts["duration"] == pytest.approx(0.5)
    assert "force.mp4" in output
    assert [item.name for item in path.parent.iterdir()] == ["force.mp4"]


def test_gif_has_every_frame_for_its_time(open_contexts: None, tmp_path: Path) -> None:
    path = tmp_path / "force.gif"
    record(FORCE, *CONTROLLER, *SHORT, "--slow", "2", "--output", str(path))
    with Image.open(path) as image:
        assert image.size == (192, 144)
        assert getattr(image, "n_frames") == 9  # noqa: B009 (Pillow declares no type)
        assert image.info["duration"] == 100


def test_frames_show_the_episode_and_its_numbers(
    open_contexts: None, tmp_path: Path, lines: list[str]
) -> None:
    record(FORCE, *CONTROLLER, *SHORT, "--output", str(tmp_path / "frames"))
    frames = frames_of(tmp_path / "frames")
    assert len(frames) == 5
    assert all(frame.shape == (144, 192, 3) for frame in frames)
    assert all((one != other).any() for one, other in itertools.pairwise(frames))
    assert [line.split("   ")[0] for line in lines] == [
        f"force_inner_position: t {0.1 * number:.2f} s" for number in range(5)
    ]
    assert all("f_d 1.00 N" in line and "position error" in line for line in lines)
    assert "f 0.00 N" in lines[0]


def test_numbers_are_those_of_the_episode(open_contexts: None, tmp_path: Path, lines: list[str]) -> None:
    import gymnasium

    record(FORCE, *CONTROLLER, *SHORT, "--duration", "1", "--fps", "1", "--output", str(tmp_path / "frames"))
    env = gymnasium.make(FORCE, scenario="report")
    policy = prp_gym.make_baseline("force_inner_position", env)
    observation, state = env.reset(seed=0)[0], None
    for _ in range(500):
        action, state = policy.predict(observation, state)
        observation = env.step(action)[0]
    force = env.get_wrapper_attr("physics").contact_force[0]
    assert f"   f {np.sqrt(force @ force):.2f} N   " in lines[-1]


def test_two_policies_see_the_same_episode(open_contexts: None, tmp_path: Path, lines: list[str]) -> None:
    path = tmp_path / "same"
    record(FORCE, *CONTROLLER, "--vs", "force_inner_position", *SHORT, "--output", str(path))
    for frame in frames_of(path):
        np.testing.assert_array_equal(frame[22:105, 2:94], frame[22:105, 98:190])
    assert lines[0::2] == lines[1::2]
    lines.clear()
    path = tmp_path / "other"
    record(FORCE, *CONTROLLER, "--vs", "operational_pd", *SHORT, "--output", str(path))
    first, last = frames_of(path)[0], frames_of(path)[-1]
    assert (first[22:105, 2:94] == first[22:105, 98:190]).all()  # the same start
    assert (last[22:105, 2:94] != last[22:105, 98:190]).mean() > 0.02
    assert lines[-2] != lines[-1].replace("operational_pd", "force_inner_position")


def test_agent_acts_beside_a_controller(open_contexts: None, tmp_path: Path, lines: list[str]) -> None:
    agent, task = "PRP-Impedance-v0/ppo_admittance", "PRP-Impedance-v0"
    record(task, "--agent", agent, "--vs", "impedance", *SHORT, "--output", str(tmp_path / "frames"))
    assert len(frames_of(tmp_path / "frames")) == 5
    assert lines[-2].startswith(f"{agent}: t 0.4")
    assert lines[-1].startswith("impedance: t 0.40 s")
    with pytest.raises(InvalidValueError, match="trained on PRP-Force-v0"):
        record(FORCE, "--agent", agent, *SHORT, "--output", str(tmp_path / "none"))


def test_settings_change_the_first_policy_alone(
    open_contexts: None, tmp_path: Path, lines: list[str]
) -> None:
    joint = "PRP-JointTracking-v0"
    arguments = ("--baseline", "joint_pd", "--set", "gravity='none'", "--vs", "joint_pd", *SHORT)
    record(joint, *arguments, "--output", str(tmp_path / "frames"))
    assert lines[-2].startswith("joint_pd (tuned, gravity='none'): t 0.40 s")
    assert lines[-1].startswith("joint_pd: t 0.40 s")
    assert lines[-2].split("tip error")[1] != lines[-1].split("tip error")[1]


def test_existing_video_is_kept(tmp_path: Path) -> None:
    path = tmp_path / "force.gif"
    path.write_bytes(b"mine")
    with pytest.raises(OutputError, match="exists already"):
        record(FORCE, *CONTROLLER, *SHORT, "--output", str(path))
    assert path.read_bytes() == b"mine"


def test_recording_that_fails_leaves_nothing(
    open_contexts: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: object) -> None:
        raise OSError("no space left on device")

    monkeypatch.setattr(Image.Image, "quantize", broken)
    path = tmp_path / "force.gif"
    with pytest.raises(OutputError, match="no space left"):
        record(FORCE, *CONTROLLER, *SHORT, "--output", str(path))
    assert list(tmp_path.iterdir()) == []
    assert not part_of(path).exists()


@pytest.mark.parametrize(("package", "suffix"), [("imageio_ffmpeg", "mp4"), ("PIL", "gif")])
def test_missing_package_is_named_with_its_install_line(
    package: str, suffix: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        prp_gym.extras, "find_spec", lambda name: None if name == package else find_spec(name)
    )
    with pytest.raises(MissingPackageError, match=rf"{package} .*pip install 'prp-gym\[record\]'"):
        record(FORCE, *CONTROLLER, *SHORT, "--output", str(tmp_path / f"force.{suffix}"))


@pytest.mark.parametrize(
    ("arguments", "error", "words"),
    [
        (("--size", "192"), InvalidValueError, "WIDTHxHEIGHT"),
        (("--size", "193x144"), InvalidValueError, "even"),
        (("--size", "10x10"), InvalidValueError, "width"),
        (("--fps", "0"), InvalidValueError, "--fps"),
        (("--slow", "nan"), PRPError, "--slow"),
        (("--output", "video.avi"), InvalidValueError, "mp4"),
        (("--output", "video.gif", "--fps", "30"), InvalidValueError, "divisor of 100"),
        (("--baseline", "impedence"), UnknownNameError, "Did you mean 'impedance'"),
        (("--vs", "impedence"), UnknownNameError, "Did you mean 'impedance'"),
        (("--scenario", "reprot"), UnknownNameError, "Did you mean 'report'"),
        (("--camera", "tsak"), UnknownNameError, "Did you mean 'task'"),
        (("--baseline", "impedance", "--agent", "x"), InvalidValueError, "one of the two"),
        (("--agent", "x", "--gains", "report"), InvalidValueError, "not with --agent"),
        (("--seed", "-1"), InvalidValueError, "seed"),
        (("--control-frequency", "333"), InvalidValueError, "control_frequency"),
    ],
)
def test_bad_input_is_refused_before_anything_is_written(
    arguments: tuple[str, ...],
    error: type[PRPError],
    words: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(error, match=words):
        record(FORCE, *arguments)
    assert list(tmp_path.iterdir()) == []


def test_unknown_environment_is_named_with_the_nearest(tmp_path: Path) -> None:
    with pytest.raises(UnknownNameError, match=r"Did you mean 'PRP-Force-v0'"):
        record("PRP-Forse-v0")
