"""What frames show beside the robot: positions and shapes, against formulas of their own."""

import numpy as np
import pytest

import prp_gym  # noqa: F401  # before MuJoCo: it chooses how MuJoCo draws
from prp_gym.drawing.overlay import Path
from prp_gym.drawing.surface_patch import HALF_SIZE, SurfacePatch
from prp_gym.drawing.trail import smooth
from prp_gym.drawing.triad import tip_axes
from prp_gym.drawing.viewpoint import FIELD_OF_VIEW, Viewpoint
from prp_gym.physics import Physics, PhysicsSettings, Surface
from prp_gym.robot import PRPArm
from prp_gym.robot.arrays import Array

STIFFNESS = 250.0  # N/m


def pressed(depth: float) -> Physics:
    """The arm at home, with its tip at a depth below a surface that it presses along +y [m]."""
    physics = Physics(settings=PhysicsSettings(surface=True))
    tip = PRPArm().forward_kinematics(np.zeros(3))[:3]
    surface = Surface.single(STIFFNESS, (0.0, -1.0, 0.0), -tip[1] + depth)
    physics.set_surface(np.arange(1), surface)
    physics.reset(np.arange(1), np.zeros((1, 3)), np.zeros((1, 3)))
    return physics


@pytest.mark.parametrize("depth", [0.004, 0.03, 0.15])
def test_surface_gives_by_the_contact_force_over_its_stiffness(depth: float) -> None:
    physics = pressed(depth)
    patch = SurfacePatch.of(physics.model(), physics.data())
    assert patch is not None
    force = float(np.sqrt(np.square(physics.contact_force[0]).sum()))
    assert patch.depth == pytest.approx(force / STIFFNESS, rel=1e-3)  # solimp adds 0.13 g of mass
    face = patch._face(24, 6)
    # the middle of the dent touches the lowest point of the tip's ball, and the rim stays where it was
    lowest = physics.tip_position[0] + np.array([0.0, 0.02, 0.0])
    np.testing.assert_allclose(face[0], np.broadcast_to(lowest, face[0].shape), atol=1e-9)
    np.testing.assert_allclose((face[-1] - patch.center) @ patch.axes[:, 2], 0.0, atol=1e-12)
    assert np.abs((face[-1] - patch.center) @ patch.axes[:, :2]).max() == pytest.approx(HALF_SIZE)


def test_surface_out_of_touch_is_flat() -> None:
    physics = pressed(-0.05)
    patch = SurfacePatch.of(physics.model(), physics.data())
    assert patch is not None
    assert patch.depth == 0.0
    np.testing.assert_allclose((patch._face(8, 3) - patch.center) @ patch.axes[:, 2], 0.0, atol=1e-12)


def test_world_without_a_surface_has_no_patch() -> None:
    physics = Physics()
    assert SurfacePatch.of(physics.model(), physics.data()) is None


def test_axes_of_a_pose_are_those_of_the_arms_last_frame() -> None:
    arm, rng = PRPArm(), np.random.default_rng(3)
    for q in rng.uniform([-3.0, -0.3, -1.5], [3.0, 0.0, 1.5], (20, 3)):
        axes = tip_axes(arm.forward_kinematics(q)[3:])
        np.testing.assert_allclose(axes, arm.transforms(q)[4, :3, :3], atol=1e-12)


def test_smooth_line_keeps_its_points_and_has_small_corners() -> None:
    angle = np.linspace(0.0, np.pi, 12)
    points = np.stack([0.3 * np.cos(angle), 0.3 * np.sin(angle), np.zeros_like(angle)], axis=-1)
    line = smooth(points)
    nearest = np.sqrt(np.square(line[:, None] - points).sum(axis=-1)).min(axis=0)
    np.testing.assert_allclose(nearest, 0.0, atol=1e-12)
    inner = line[(line[:, 1] > 0.05)]
    # a Catmull-Rom spline through points 0.27 rad apart on a circle leaves it by less than a millimetre
    np.testing.assert_allclose(np.sqrt(np.square(inner).sum(axis=-1)), 0.3, atol=1e-3)
    assert len(line) > 3 * len(points)


def projected(view: Viewpoint, points: Array, aspect: float) -> Array:
    """Positions in the frame (k, 2), -1 to 1 from edge to edge, by a rotation written out."""
    az, el = np.radians(view.azimuth), np.radians(view.elevation)
    forward = np.array([np.cos(el) * np.cos(az), np.cos(el) * np.sin(az), np.sin(el)])
    right = np.cross(forward, (0.0, 0.0, 1.0))
    right /= np.sqrt(right @ right)
    up = np.cross(right, forward)
    apart = points - (view.lookat - view.distance * forward)
    tall = np.tan(np.radians(FIELD_OF_VIEW / 2)) * (apart @ forward)
    return np.stack([apart @ right / (aspect * tall), apart @ up / tall], axis=-1)


@pytest.mark.parametrize("aspect", [0.6, 1.0, 16 / 9])
def test_views_are_filled_by_the_points_that_they_frame(aspect: float) -> None:
    rng = np.random.default_rng(5)
    for _ in range(10):
        points = rng.uniform(-0.5, 0.5, (30, 3))
        seen = projected(Viewpoint.around(points, rng.uniform(0, 360), aspect), points, aspect)
        assert np.abs(seen).max() < 1.0
        assert np.abs(seen).max() > 0.8


@pytest.mark.parametrize("aspect", [1.0, 16 / 9])
def test_task_camera_frames_path_and_contact(aspect: float) -> None:
    angle = np.linspace(0.0, 4.0, 50)
    path = np.stack([0.6 * np.cos(angle), 0.6 * np.sin(angle), 0.1 * np.sin(3 * angle)], axis=-1)
    overlay = [Path(path, 2.0, (0.0, 0.0, 1.0, 1.0))]
    assert np.abs(projected(Viewpoint.of_task(None, overlay, aspect), path, aspect)).max() < 1.0
    physics = pressed(0.01)
    patch = SurfacePatch.of(physics.model(), physics.data())
    for view in (Viewpoint.of_task(patch, overlay, aspect), Viewpoint.of_contact(patch, aspect)):  # type: ignore[arg-type]
        tip = projected(view, physics.tip_position, aspect)
        assert np.abs(tip).max() < 0.75
