"""Tests of compiled code are skipped where there is no C compiler."""

import pytest

from prp_gym.errors import CompilerError
from prp_gym.symbolic.compiler import find_compiler


def _is_missing() -> bool:
    try:
        find_compiler()
    except CompilerError:
        return True
    return False


needs_compiler = pytest.mark.skipif(_is_missing(), reason="no C compiler on this machine")
