"""What tests of several modules need."""

import os

import pytest

from prp_gym.errors import RenderingError
from prp_gym.physics import Physics
from prp_gym.physics.rendering import OffscreenRenderer


@pytest.fixture(scope="session")
def drawing() -> None:
    """Skip where no picture can be drawn, unless that must not be."""
    try:
        OffscreenRenderer(Physics().model(), 64, 64, "top").close()
    except (RenderingError, ImportError) as error:
        if os.environ.get("PRP_REQUIRE_RENDERING") == "1":
            pytest.fail(f"PRP_REQUIRE_RENDERING=1, but: {error}")
        pytest.skip(f"no drawing context on this machine: {error}")
