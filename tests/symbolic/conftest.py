"""Where compiled code is kept while these tests run."""

from collections.abc import Iterator

import pytest


@pytest.fixture(scope="package", autouse=True)
def folder_of_compiled_code(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Nothing is taken from the user's own folder of caches, nor left there."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PRP_GYM_CACHE", str(tmp_path_factory.mktemp("compiled")))
        yield
