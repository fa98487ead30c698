"""The scene has the bodies of the simulation where they are, and the controls show the session."""

from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np
import pytest

from prp_gym.viewing.policy_catalogue import PolicyCatalogue
from prp_gym.viewing.session import Session
from prp_gym.viewing.viewer import Viewer
from tests.support.viewing_sessions import SEED, controller_session, controller_source

pytest.importorskip("viser", reason="the extra `view` is not installed")

FORCE = "PRP-Force-v0"


@pytest.fixture
def server() -> Iterator[Any]:
    from prp_gym.viewing.web.server import serving

    with serving("127.0.0.1", 0, "prp_gym") as started:
        yield started


def make_page(server: Any, session: Session) -> tuple[Viewer, Any]:
    from prp_gym.viewing.web.page import Page

    viewer = Viewer(session)
    environment_id = session.inner.task.environment_id
    return viewer, Page(server, viewer, PolicyCatalogue(environment_id, 500.0, session.source))


@pytest.mark.parametrize(
    ("environment_id", "controller"),
    [
        (FORCE, "parallel_force_position"),
        ("PRP-JointTracking-v0", "joint_pd"),
        ("PRP-Adaptive-v0", "adaptive"),
    ],
)
def test_bodies_are_where_the_simulation_has_them(server: Any, environment_id: str, controller: str) -> None:
    from prp_gym.viewing.web.scene import SceneView

    session, scene = controller_session(environment_id, controller), SceneView(server.scene)
    for seed in (SEED, SEED + 1):
        session.reset(seed)
        session.advance(40)
        scene.show(session)
        data = session.inner.physics.data()
        assert "link_1" in scene.bodies
        assert ("surface" in scene.bodies) == session.has_surface
        for name, frame in scene.bodies.items():
            assert frame.position == pytest.approx(data.body(name).xpos, abs=1e-12)
            assert frame.wxyz == pytest.approx(data.body(name).xquat, abs=1e-12)


@pytest.mark.parametrize(
    ("environment_id", "controller"), [("PRP-JointTracking-v0", "joint_pd"), ("PRP-Adaptive-v0", "adaptive")]
)
def test_ghost_stands_at_the_reference_of_the_joints(
    server: Any, environment_id: str, controller: str
) -> None:
    from prp_gym.viewing.web.scene import SceneView

    session, scene = controller_session(environment_id, controller), SceneView(server.scene)
    session.advance(40)
    scene.show(session)
    model = session.inner.physics.model()
    data = mujoco.MjData(model)
    data.qpos[:] = session.signals.fields["desired_joint_position"][-1]
    mujoco.mj_forward(model, data)
    assert set(scene.ghost) == {name for name in scene.bodies if name.startswith("link")}
    for name, frame in scene.ghost.items():
        assert frame.position == pytest.approx(data.body(name).xpos, abs=1e-12)
        assert frame.wxyz == pytest.approx(data.body(name).xquat, abs=1e-12)


def test_desired_frame_is_shown_where_the_reference_is_a_pose(server: Any) -> None:
    from prp_gym.viewing.web.scene import SceneView

    session, scene = controller_session("PRP-PoseTracking-v0", "operational_pd"), SceneView(server.scene)
    session.advance(40)
    scene.show(session)
    pose = session.signals.fields["desired_pose"][-1]
    starts, ends = scene.axes.points[:, 0], scene.axes.points[:, 1]
    # the axis z of the end-effector frame at the angles α, β, γ: a turn of β about an axis that α turned
    approach = [
        np.sin(pose[4]) * np.sin(pose[3]),
        -np.sin(pose[4]) * np.cos(pose[3]),
        np.cos(pose[4]),
    ]
    assert scene.ghost == {}
    np.testing.assert_allclose(starts, np.tile(pose[:3], (3, 1)), atol=1e-6)  # 32-bit numbers
    np.testing.assert_allclose(ends[2] - starts[2], 0.12 * np.array(approach), atol=1e-6)
    axes = (ends - starts) / np.linalg.norm(ends - starts, axis=1, keepdims=True)
    np.testing.assert_allclose(np.cross(axes[0], axes[1]), axes[2], atol=1e-5)


def test_every_visible_geom_of_the_arm_is_drawn(server: Any) -> None:
    from prp_gym.viewing.web.geoms import add_geoms

    model = controller_session(FORCE, "parallel_force_position").inner.physics.model()
    add_geoms(server.scene, model)
    drawn = {name for name in server.scene._handle_from_node_name if name.startswith("/bodies/")}
    known = (mujoco.mjtGeom.mjGEOM_PLANE, mujoco.mjtGeom.mjGEOM_BOX, mujoco.mjtGeom.mjGEOM_SPHERE)
    kinds = {int(kind) for kind in model.geom_type[model.geom_group <= 2]}
    assert {int(kind) for kind in known} <= kinds
    assert len({name for name in drawn if name.count("/") == 3}) == np.count_nonzero(model.geom_group <= 2)


def test_page_shows_the_state_of_the_session(server: Any) -> None:
    from prp_gym.viewing.web.page import status_text

    viewer, page = make_page(server, controller_session(FORCE, "parallel_force_position"))
    session = viewer.session
    session.advance(100)
    session.set_surface("surface_stiffness", 500.0)
    assert page.show(viewer)
    text = status_text(viewer)
    for shown in (FORCE, "scenario randomized", f"seed {SEED}", "running at 0.20 of 5 s", "real-time factor"):
        assert shown in text
    session.pause()
    assert "paused" in status_text(viewer)


def test_another_controller_brings_its_sliders_and_gain_sets(server: Any) -> None:
    viewer, page = make_page(server, controller_session(FORCE, "parallel_force_position"))
    viewer.session.choose_source(controller_source(FORCE, "impedance", "figures"))
    page.policy.refresh()
    assert set(page.policy.sliders) == {item.name for item in viewer.session.parameters}
    assert (page.policy.choice.value, page.policy.gains.value) == ("impedance", "figures")
    assert "damping" in page.policy.values.content
    assert "N·s/m" in page.policy.values.content


def test_agent_has_no_sliders(server: Any) -> None:
    viewer, page = make_page(server, controller_session(FORCE, "parallel_force_position"))
    agent = "PRP-Force-v0/ppo_variable_force_position"
    viewer.session.choose_source(PolicyCatalogue(FORCE, 500.0, viewer.session.source).make(agent))
    page.policy.refresh()
    assert page.policy.sliders == {}
    assert page.policy.choice.value == agent
    page.show(viewer)
