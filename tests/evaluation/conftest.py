"""What tests of evaluations share."""

import pytest

from prp_gym.evaluation import batch, compiled_batch


@pytest.fixture
def timed_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """The compute time of policies, which is no part of what episodes are compared by, is measured once."""
    for module in (batch, compiled_batch):
        monkeypatch.setattr(module, "_TIMED", 1)
