"""Frames: shape and content, of the current state, with the overlay in its colours."""

import itertools
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import prp_gym  # noqa: F401  # before MuJoCo: it chooses how MuJoCo draws

# isort: split
import mujoco

from prp_gym.errors import InvalidValueError, RenderingError, UnknownNameError
from prp_gym.physics import CAMERAS, LinkPhysics, Physics, PhysicsSettings, Surface
from prp_gym.physics.renderer_pool import MOST_GEOMS
from prp_gym.physics.rendering import (
    Arrow,
    Ball,
    OffscreenRenderer,
    OverlayItem,
    Path,
    WindowRenderer,
    check_view,
)
from prp_gym.physics.scene import FIXED_CAMERAS, FLOOR_HEIGHT
from prp_gym.robot import PRPArm

WIDTH, HEIGHT = 96, 64
TOP_HEIGHT = 2.0  # of the top camera above the arm's foot [m]
pytestmark = pytest.mark.usefixtures("open_contexts")
RED, GREEN, BLUE = (1.0, 0.0, 0.0, 1.0), (0.0, 1.0, 0.0, 1.0), (0.0, 0.0, 1.0, 1.0)
CENTER = np.array([0.1, 0.0, 0.6])  # under the top camera, above the arm
Frame = NDArray[Any]


@pytest.fixture(params=FIXED_CAMERAS)
def camera(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def physics() -> Physics:
    return Physics(settings=PhysicsSettings(surface=True))


@pytest.fixture
def renderer(drawing: None, physics: Physics, camera: str) -> Iterator[OffscreenRenderer]:
    opened = OffscreenRenderer(physics.model(), WIDTH, HEIGHT, camera)
    yield opened
    opened.close()


@pytest.fixture
def top(drawing: None, physics: Physics) -> Iterator[OffscreenRenderer]:
    opened = OffscreenRenderer(physics.model(), WIDTH, HEIGHT, "top")
    yield opened
    opened.close()


def set_joints(physics: Physics, q: tuple[float, float, float]) -> None:
    physics.reset(np.arange(1), np.array([q]), np.zeros((1, 3)))


def changed(before: Frame, after: Frame) -> NDArray[np.bool_]:
    """Pixels that differ by more than shading's last digits."""
    apart: NDArray[np.bool_] = np.abs(before.astype(int) - after.astype(int)).max(axis=-1) > 8
    return apart


def test_colour_frame_has_shape_type_and_content(renderer: OffscreenRenderer, physics: Physics) -> None:
    frame = renderer.draw(physics.data(), [])
    assert frame.shape == (HEIGHT, WIDTH, 3)
    assert frame.dtype == np.uint8
    assert frame.std() > 5.0
    assert len(np.unique(frame.reshape(-1, 3), axis=0)) > 50


def test_same_state_gives_the_same_frame_and_another_state_another(
    renderer: OffscreenRenderer, physics: Physics
) -> None:
    set_joints(physics, (0.0, -0.1, 0.0))
    first = renderer.draw(physics.data(), [])
    kept = first.copy()
    set_joints(physics, (1.2, -0.2, 0.7))
    second = renderer.draw(physics.data(), [])
    np.testing.assert_array_equal(first, kept)  # not overwritten by the next frame
    assert changed(first, second).sum() > 50
    set_joints(physics, (0.0, -0.1, 0.0))
    np.testing.assert_array_equal(renderer.draw(physics.data(), []), first)


def test_cameras_see_different_frames(drawing: None, physics: Physics) -> None:
    frames = []
    for name in CAMERAS:
        renderer = OffscreenRenderer(physics.model(), WIDTH, HEIGHT, name)
        frames.append(renderer.draw(physics.data(), []))
        renderer.close()
    for one, other in itertools.combinations(frames, 2):
        assert changed(one, other).mean() > 0.25


def test_depth_from_above_is_the_distance_to_floor_and_tip_in_metres(
    top: OffscreenRenderer, physics: Physics
) -> None:
    q = (0.0, -0.15, 0.9)
    set_joints(physics, q)
    depth = top.draw(physics.data(), [], depth=True)
    assert depth.shape == (HEIGHT, WIDTH)
    assert depth.dtype == np.float32
    # 24 bits between 0.01 and 20 m, nonlinear: a millimetre at 2 m
    assert float(np.median(depth)) == pytest.approx(TOP_HEIGHT - FLOOR_HEIGHT, abs=1e-3)
    assert float(depth.max()) == pytest.approx(TOP_HEIGHT - FLOOR_HEIGHT, abs=1e-3)
    highest = PRPArm().forward_kinematics(q)[2] + 0.02  # the sphere at the tip has this radius
    # a pixel spans 25 mm: the nearest one may miss the sphere's pole by 7 mm of depth
    assert float(depth.min()) == pytest.approx(TOP_HEIGHT - highest, abs=0.01)


def test_depth_and_colour_can_alternate(renderer: OffscreenRenderer, physics: Physics) -> None:
    colour = renderer.draw(physics.data(), [])
    depth = renderer.draw(physics.data(), [], depth=True)
    np.testing.assert_array_equal(renderer.draw(physics.data(), []), colour)
    np.testing.assert_array_equal(renderer.draw(physics.data(), [], depth=True), depth)
    assert np.isfinite(depth).all()
    assert (depth > 0.0).all()


OVERLAYS: dict[str, tuple[OverlayItem, int]] = {
    "ball": (Ball(CENTER, 0.1, RED), 0),
    "path": (Path(CENTER + np.array([[-0.2, 0, 0], [0, 0.2, 0], [0.2, 0, 0.0]]), 0.04, GREEN), 1),
    "arrow": (Arrow(CENTER, np.array([0.0, 0.3, 0.0]), 0.04, BLUE), 2),
}


@pytest.mark.parametrize("name", list(OVERLAYS))
def test_overlay_item_is_seen_in_its_colour(name: str, renderer: OffscreenRenderer, physics: Physics) -> None:
    item, channel = OVERLAYS[name]
    plain = renderer.draw(physics.data(), [])
    with_overlay = renderer.draw(physics.data(), [item])
    of_colour = with_overlay[..., channel] > 2 * np.delete(with_overlay, channel, axis=-1).max(
        axis=-1
    ).astype(int)
    of_colour &= changed(plain, with_overlay)
    assert of_colour.sum() > 10
    np.testing.assert_array_equal(renderer.draw(physics.data(), []), plain)


def test_ball_stands_where_it_was_put(top: OffscreenRenderer, physics: Physics) -> None:
    plain = top.draw(physics.data(), []).astype(int)
    with_overlay = top.draw(physics.data(), [Ball(CENTER, 0.1, RED)]).astype(int)
    # by how much it became redder than it became brighter: the ball, but not its shadow
    red = (with_overlay[..., 0] - with_overlay[..., 2]) - (plain[..., 0] - plain[..., 2]) > 40
    # the camera looks down on (0.1, 0): the frame's middle
    rows, columns = np.nonzero(red)
    assert rows.mean() == pytest.approx((HEIGHT - 1) / 2, abs=1.0)
    assert columns.mean() == pytest.approx((WIDTH - 1) / 2, abs=1.0)


def test_overlay_items_have_no_depth(top: OffscreenRenderer, physics: Physics) -> None:
    plain = top.draw(physics.data(), [], depth=True)
    with_overlay = top.draw(physics.data(), [Ball(CENTER, 0.1, RED)], depth=True)
    np.testing.assert_array_equal(with_overlay, plain)


def test_overlay_items_beyond_the_scenes_capacity_are_left_out(
    top: OffscreenRenderer, physics: Physics
) -> None:
    aside = CENTER + np.array([0.15, 0.0, 0.0])
    overlay: list[OverlayItem] = [Ball(CENTER, 0.1, RED), *[Ball(aside, 0.005, GREEN)] * MOST_GEOMS]
    overlay.append(Ball(CENTER, 0.3, BLUE))
    frame = top.draw(physics.data(), overlay)
    np.testing.assert_array_equal(frame, top.draw(physics.data(), overlay[:-1]))
    assert (frame[..., 0] > 2 * frame[..., 2].astype(int)).sum() > 10


def test_surface_is_drawn_where_it_was_set(drawing: None, physics: Physics) -> None:
    frames = []
    for offset in (0.5, 0.35):
        physics.set_surface(np.arange(1), Surface.single(100.0, (0.0, -1.0, 0.0), offset))
        set_joints(physics, (0.0, -0.2, 0.0))
        renderer = OffscreenRenderer(physics.model(), WIDTH, HEIGHT, "overview")
        frames.append(renderer.draw(physics.data(), []))
        renderer.close()
    assert changed(*frames).sum() > 50


@pytest.mark.parametrize("camera", FIXED_CAMERAS)
def test_link_is_seen_swinging_by_both_cameras(drawing: None, camera: str) -> None:
    link, columns = LinkPhysics(num_simulations=3), []
    link.reset(np.arange(3), np.array([[1.0], [-1.0], [0.0]]), np.zeros((3, 1)))
    renderer = OffscreenRenderer(link.model(), WIDTH, HEIGHT, camera)
    hanging = renderer.draw(link.data(2), [])
    for row in range(2):
        seen = changed(renderer.draw(link.data(row), []), hanging)
        assert seen.sum() > 8
        columns.append(np.nonzero(seen)[1].mean())
    renderer.close()
    # both cameras have the world's x axis to the right; a pixel spans 25 mm or less
    assert columns[0] - columns[1] > 3.0


def test_frame_may_be_larger_than_mujocos_default_buffer(drawing: None, physics: Physics) -> None:
    renderer = OffscreenRenderer(physics.model(), 800, 700, "top")
    assert renderer.draw(physics.data(), []).shape == (700, 800, 3)
    renderer.close()


def test_close_may_be_called_twice(drawing: None, physics: Physics) -> None:
    renderer = OffscreenRenderer(physics.model(), WIDTH, HEIGHT, "top")
    renderer.close()
    renderer.close()
    again = OffscreenRenderer(physics.model(), WIDTH, HEIGHT, "top")
    assert again.draw(physics.data(), []).std() > 5.0
    again.close()


def test_unknown_camera_is_named_with_the_known_ones() -> None:
    with pytest.raises(UnknownNameError, match="overveiw") as caught:
        OffscreenRenderer(Physics().model(), WIDTH, HEIGHT, "overveiw")
    assert caught.value.valid == tuple(sorted(CAMERAS))
    assert "Did you mean 'overview'" in str(caught.value)


@pytest.mark.parametrize(("width", "height", "what"), [(0, 64, "width"), (96, -3, "height")])
def test_size_must_be_positive(width: int, height: int, what: str) -> None:
    with pytest.raises(InvalidValueError, match=what) as caught:
        OffscreenRenderer(Physics().model(), width, height, "top")
    assert caught.value.unit == "pixels"
    with pytest.raises(InvalidValueError, match=what):
        check_view(width, height, "top")


@pytest.mark.parametrize("kind", [RuntimeError, AttributeError, ImportError])
def test_machine_that_cannot_draw_is_told_what_to_do(
    kind: type[Exception], monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: object, **__: object) -> None:
        raise kind("no context")

    monkeypatch.setattr(mujoco, "Renderer", broken)
    with pytest.raises(RenderingError, match="MUJOCO_GL=egl") as caught:
        OffscreenRenderer(Physics().model(), WIDTH + 1, HEIGHT, "top")  # of which no context is open
    assert isinstance(caught.value.__cause__, kind)


def test_window_wants_a_known_camera_and_a_display(monkeypatch: pytest.MonkeyPatch) -> None:
    physics = Physics()
    with pytest.raises(UnknownNameError, match="camera"):
        WindowRenderer(physics.model(), physics.data(), "front")
    monkeypatch.setattr("sys.platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    with pytest.raises(RenderingError, match="display"):
        WindowRenderer(physics.model(), physics.data(), "top")
