"""`RendererPool`: frames of the same size and of equal worlds share an OpenGL context, freed at last."""

import gc
import resource
import weakref
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import prp_gym  # noqa: F401  # before MuJoCo: it chooses how MuJoCo draws
from prp_gym.physics import Physics, PhysicsSettings, Surface
from prp_gym.physics.rendering import OffscreenRenderer

WIDTH, HEIGHT = 96, 64


@pytest.fixture
def physics() -> Physics:
    return Physics(settings=PhysicsSettings(surface=True))


def memory() -> float:
    """Memory that this process occupies [MB]."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize() / 1e6


@pytest.mark.skipif(
    not Path("/proc/self/statm").exists(), reason="the system does not tell a process's memory"
)
def test_closed_renderers_give_their_memory_back_and_open_ones_share_it(
    drawing: None, physics: Physics
) -> None:
    def draw() -> OffscreenRenderer:
        opened = OffscreenRenderer(physics.model(), WIDTH, HEIGHT, "top")
        opened.draw(physics.data(), [])
        return opened

    before = memory()
    draw().close()
    one = memory() - before  # with what OpenGL allocates once
    for _ in range(6):
        draw().close()
    closed = memory()
    assert closed < before + one + 20.0  # MB: half of a context, of which each took 37 before
    together = [draw() for _ in range(4)]
    assert memory() < closed + 80.0  # one context with its scenes, not four
    for renderer in together:
        renderer.close()
        renderer.close()
    assert memory() < closed + 20.0


def test_renderers_that_share_a_context_draw_what_each_would_draw_alone(drawing: None) -> None:
    frames: dict[str, list[NDArray[Any]]] = {"alone": [], "together": []}
    surfaces = [Surface.single(500.0, (0.0, 0.0, 1.0), offset) for offset in (0.2, 0.5)]
    worlds = [Physics(settings=PhysicsSettings(surface=True)) for _ in surfaces]
    for world, surface in zip(worlds, surfaces, strict=True):
        world.set_surface(np.arange(1), surface)
        world.reset(np.arange(1), np.array([[0.3, -0.1, 0.4]]), np.zeros((1, 3)))
        renderer = OffscreenRenderer(world.model(), WIDTH, HEIGHT, "overview")
        frames["alone"].append(renderer.draw(world.data(), []))
        renderer.close()
    together = [OffscreenRenderer(world.model(), WIDTH, HEIGHT, "overview") for world in worlds]
    frames["together"] = [r.draw(world.data(), []) for r, world in zip(together, worlds, strict=True)]
    for renderer in together:
        renderer.close()
    assert (frames["alone"][0] != frames["alone"][1]).any()
    np.testing.assert_array_equal(frames["together"], frames["alone"])


def test_arms_of_other_masses_and_friction_share_a_context(drawing: None) -> None:
    arms = Physics(num_simulations=3)
    factors, friction = np.array([[1.0, 1.0, 1.0], [0.7, 1.3, 0.8], [1.2, 0.9, 1.1]]), np.full((3, 3), 0.05)
    arms.set_dynamics(np.arange(3), factors, np.diag([0.0, 0.5, 0.2]), friction)
    renderers = [OffscreenRenderer(arms.model(row), WIDTH, HEIGHT, "overview") for row in range(3)]
    assert len({id(renderer._renderer) for renderer in renderers}) == 1
    frames = [renderer.draw(arms.data(row), []) for row, renderer in enumerate(renderers)]
    np.testing.assert_array_equal(frames, [frames[0]] * 3)
    for renderer in renderers:
        renderer.close()


def test_renderer_that_nobody_closed_frees_its_context(drawing: None, physics: Physics) -> None:
    renderer = OffscreenRenderer(physics.model(), WIDTH, HEIGHT, "top")
    context = weakref.ref(renderer._renderer)
    del renderer
    gc.collect()
    assert context() is None
