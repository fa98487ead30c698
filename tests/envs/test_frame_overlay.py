"""The overlay of frames: present reference, trail, forces with their values, phase of contact."""

from typing import Any

import gymnasium
import numpy as np
import pytest

import prp_gym
from prp_gym.drawing.contact_ring import FREE, LOST, TOUCHING, ContactRing
from prp_gym.drawing.ghost import Ghost
from prp_gym.drawing.overlay import Arrow, Ball, DashedArrow, OverlayItem, Path
from prp_gym.drawing.trail import Trail
from prp_gym.drawing.triad import Triad
from prp_gym.envs import PRPEnv

DRAWN: dict[str, Any] = {"render_mode": "rgb_array", "width": 64, "height": 48}


def made(environment_id: str, **keywords: Any) -> PRPEnv:
    env = gymnasium.make(environment_id, **{**DRAWN, **keywords}).unwrapped
    assert isinstance(env, PRPEnv)
    return env


def run(env: PRPEnv, controller: str, seconds: float, seed: int = 0) -> list[np.ndarray[Any, Any]]:
    """Run a controller; the positions of the tip after every step."""
    policy = prp_gym.make_baseline(controller, env)
    observation, _ = env.reset(seed=seed)
    state, tips = None, []
    for _ in range(round(seconds * env.control_frequency)):
        action, state = policy.predict(observation, state)
        observation = env.step(action)[0]
        tips.append(env.physics.tip_position[0].copy())
    return tips


def only(env: PRPEnv, kind: type[OverlayItem]) -> Any:
    found = [item for item in env.overlay(0) if type(item) is kind]
    assert len(found) == 1
    return found[0]


def test_ghost_is_at_the_present_reference_and_not_at_the_end_of_the_path() -> None:
    env = made("PRP-JointTracking-v0", scenario="report")
    run(env, "joint_pd", 0.6)
    desired = env.observation_layout.split(env.ground_truth)["desired_joint_position"]
    np.testing.assert_array_equal(only(env, Ghost).joint_position, desired)
    assert not any(isinstance(item, Ball) for item in env.overlay(0))
    path, tip = only(env, Path).points, env.task.model.forward_kinematics(desired)[:3]  # type: ignore[union-attr]
    # the path has a point every 5 s / 300
    assert np.sqrt(np.square(path - tip).sum(axis=-1)).min() < 0.02
    assert np.sqrt(np.square(path[-1] - tip).sum()) > 0.1


def test_ghost_of_the_link_is_at_its_reference() -> None:
    env = made("PRP-Adaptive-v0", scenario="report")
    run(env, "adaptive", 0.2)
    np.testing.assert_allclose(only(env, Ghost).joint_position, [np.sin(2 * np.pi * 0.2)], atol=1e-9)


def test_frames_of_the_tip_and_of_the_desired_pose() -> None:
    env = made("PRP-PoseTracking-v0", scenario="report")
    run(env, "operational_pd", 0.3)
    fields = env.observation_layout.split(env.ground_truth)
    present, desired = (item for item in env.overlay(0) if isinstance(item, Triad))
    np.testing.assert_array_equal(present.origin, fields["end_effector_pose"][:3])
    np.testing.assert_array_equal(desired.origin, fields["desired_pose"][:3])
    assert desired.length > present.length
    assert desired.color != present.color


@pytest.mark.parametrize(("seconds", "length"), [(0.1, 6), (0.5, 26), (1.6, 51)])
def test_trail_is_where_the_tip_was_during_the_last_second(seconds: float, length: int) -> None:
    env = made("PRP-JointTracking-v0", scenario="randomized")
    tips = run(env, "joint_pd", seconds)
    trail = only(env, Trail).points
    np.testing.assert_array_equal(trail[-1], tips[-1])
    assert len(trail) == length  # 50 a second, and the present one
    np.testing.assert_array_equal(trail[:-1], tips[9::10][-(length - 1) :])


def test_trail_belongs_to_one_episode() -> None:
    env = made("PRP-JointTracking-v0")
    run(env, "joint_pd", 0.4)
    env.reset(seed=2)
    assert len(only(env, Trail).points) == 1
    state = env.get_state()
    run(env, "joint_pd", 0.4)
    env.set_state(state)
    assert len(only(env, Trail).points) == 1


def test_forces_have_their_values_and_different_shapes() -> None:
    env = made("PRP-Force-v0", scenario="report")
    run(env, "force_inner_position", 2.0)
    force, desired = only(env, Arrow), only(env, DashedArrow)
    measured = float(np.sqrt(np.square(env.physics.contact_force[0]).sum()))
    assert force.text == f"f {measured:.2f} N"
    assert desired.text == "f_d 1.00 N"
    assert force.color != desired.color
    sizes = [float(np.sqrt(np.square(arrow.vector).sum())) for arrow in (force, desired)]
    assert sizes[0] / sizes[1] == pytest.approx(measured, rel=1e-9)
    np.testing.assert_allclose(force.vector / sizes[0], [0.0, 1.0, 0.0], atol=1e-6)


def test_phase_of_contact_is_free_touching_and_lost() -> None:
    env = made("PRP-Force-v0", scenario="report")
    run(env, "force_inner_position", 0.002)
    assert only(env, ContactRing).phase == FREE
    run(env, "force_inner_position", 1.0)
    assert only(env, ContactRing).phase == TOUCHING
    for _ in range(400):
        env.step(np.array([0.0, 1.0, 0.0], dtype=np.float32))  # extends the slide, away from the surface
        if not env.physics.contact_force.any():
            break
    assert only(env, ContactRing).phase == LOST
    env.reset(seed=1)
    assert only(env, ContactRing).phase == FREE


def test_drawing_leaves_every_step_as_it_is() -> None:
    drawn, plain = made("PRP-Force-v0"), gymnasium.make("PRP-Force-v0").unwrapped
    np.testing.assert_array_equal(drawn.reset(seed=3)[0], plain.reset(seed=3)[0])
    rng = np.random.default_rng(0)
    for _ in range(60):
        action = rng.uniform(-0.1, 0.1, 3).astype(np.float32)
        drawn.overlay(0)
        np.testing.assert_array_equal(drawn.step(action)[0], plain.step(action)[0])


def test_large_frames_show_labels_that_small_ones_leave_out(open_contexts: None) -> None:
    shapes, pressing = {}, made("PRP-Force-v0")
    run(pressing, "force_inner_position", 1.0)
    for height in (84, 300, 400):
        env = made("PRP-Force-v0", width=height, height=height)
        env.set_state(pressing.get_state())
        frame = env.render()
        assert frame is not None
        assert frame.shape == (height, height, 3)
        scene = env._renderer._renderer.scene  # type: ignore[union-attr]
        shapes[height] = {scene.geoms[index].label for index in range(scene.ngeom)} - {""}
        env.close()
    assert shapes[84] == set()
    assert "touching" in shapes[300]
    assert "x 0.5 m" not in shapes[300]  # where the numbers of the floor would hide those of the forces
    assert {"touching", "x 0.5 m"} <= shapes[400]
    assert any(text.startswith("f_d ") for text in shapes[300])


def test_full_hd_frames_are_drawn(open_contexts: None) -> None:
    env = made("PRP-JointTracking-v0", width=1920, height=1080)
    env.reset(seed=0)
    frame = env.render()
    assert frame is not None
    assert frame.shape == (1080, 1920, 3)
    colours = frame @ np.array([1, 256, 65536])  # one number each, which are sorted faster than rows of three
    assert len(np.unique(colours)) > 500
    env.close()
