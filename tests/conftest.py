"""What tests of several modules need."""

import gc
import os
from collections.abc import Hashable, Iterator

import pytest
from hypothesis import settings

from prp_gym.action_modes import ACTION_MODES, register_action_mode
from prp_gym.errors import RenderingError
from prp_gym.physics import Physics
from prp_gym.physics.renderer_pool import RendererPool
from prp_gym.physics.rendering import OffscreenRenderer
from tests.support.compiler import needs_compiler
from tests.support.synthetic_mode import LATE

# isort: split
import mujoco  # after prp_gym, which chooses how it draws

# the same examples in every run, however busy the machine is
settings.register_profile("suite", deadline=None, derandomize=True)
settings.load_profile("suite")


if needs_compiler.args[0]:
    # what commands say is checked without the line that a compiler is missing, which has tests of its own
    os.environ["PRP_GYM_COMPILED"] = "0"


def pytest_collection_finish() -> None:
    """Cases and imported libraries stay to the end, so that no search for unreachable objects visits them."""
    gc.freeze()


@pytest.fixture(scope="session")
def drawing() -> None:
    """Skip where no frame can be rendered, unless that must not be."""
    try:
        OffscreenRenderer(Physics().model(), 64, 64, "top").close()
    except (RenderingError, ImportError) as error:
        if os.environ.get("PRP_REQUIRE_RENDERING") == "1":
            pytest.fail(f"PRP_REQUIRE_RENDERING=1, but: {error}")
        pytest.skip(f"no drawing context on this machine: {error}")


@pytest.fixture(scope="module")
def open_contexts(drawing: None) -> Iterator[None]:
    """OpenGL contexts stay open up to the end of a module of tests: to make one takes a third of a second."""
    borrow, kept = RendererPool.borrow, dict[Hashable, RendererPool]()

    def borrow_and_keep(
        pool: RendererPool, model: mujoco.MjModel, width: int, height: int
    ) -> tuple[Hashable, mujoco.Renderer]:
        key, renderer = borrow(pool, model, width, height)
        if key not in kept:
            borrow(pool, model, width, height)
            kept[key] = pool
        return key, renderer

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(RendererPool, "borrow", borrow_and_keep)
        yield
    for key, pool in kept.items():
        pool.give_back(key)


@pytest.fixture
def unwritten_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    """`prp-gym compare` draws its figures, but writes no files of them, of which each takes half a second."""
    monkeypatch.setattr("prp_gym.cli.compare.write_figure", lambda path, figure: None)


@pytest.fixture
def late_mode() -> Iterator[None]:
    """The action mode `late`, registered for one test."""
    register_action_mode(LATE)
    yield
    ACTION_MODES.unregister(LATE.name)
