"""Where compiled code and traced functions are kept while these tests run."""

from collections.abc import Iterator

import pytest

from prp_gym.symbolic import lifting


@pytest.fixture(scope="package", autouse=True)
def folder_of_compiled_code(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Nothing is taken from the user's own folder of caches, nor left there."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PRP_GYM_CACHE", str(tmp_path_factory.mktemp("compiled")))
        yield


@pytest.fixture
def nothing_known(monkeypatch: pytest.MonkeyPatch) -> None:
    """No function is known before a test, and those of a test are forgotten."""
    monkeypatch.setattr(lifting, "_KNOWN", {})
