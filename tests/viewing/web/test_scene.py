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
