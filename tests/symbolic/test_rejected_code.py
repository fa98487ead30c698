"""A compiler that works and rejects generated code is told from one that does not work."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from prp_gym.errors import CompilerError, GeneratedCodeError
from prp_gym.symbolic.compiler import load_library
from tests.support.compiler import choose_compiler, forget_compiler, needs_compiler

GOOD = "\nint four(void) { return 4; }\n"
BAD = """static int six(void)
{
    return 6;
}

int seven(int log)
{
    int log = six();
    return log
}
"""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """An empty cache, and no knowledge of a compiler before and after a test."""
    forget_compiler()
    monkeypatch.setenv("PRP_GYM_CACHE", str(tmp_path / "cache"))
    yield tmp_path / "cache"
    forget_compiler()


@needs_compiler
def test_bad_code_is_rejected_with_the_function_and_the_first_errors(folder: Path) -> None:
    with pytest.raises(GeneratedCodeError, match="rejects the C code of the function 'seven'") as rejected:
        load_library(BAD)
    first, second = str(rejected.value).splitlines()[-2:]
    assert first.startswith("generated.c:8:")
    assert second.startswith("generated.c:9:")
    assert not folder.exists()


@needs_compiler
def test_rejected_code_is_no_missing_compiler() -> None:
    """Else code that lets NumPy stand in for a missing compiler would hide it."""
    assert not issubclass(GeneratedCodeError, CompilerError)


@pytest.mark.parametrize("language", ["de_DE.UTF-8", "C"])
def test_messages_are_read_in_english(language: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A compiler that translates, as gcc does, is told not to."""
    word = '$([ "$LC_ALL" = C ] && echo error || echo Fehler)'
    own = f'for part; do case $part in *generated.c) echo "$part:2: {word}: wrong" >&2; exit 1;; esac; done'
    monkeypatch.setenv("LC_ALL", language)
    choose_compiler(monkeypatch, tmp_path / "own-compiler", own)
    with pytest.raises(GeneratedCodeError, match="'four'"):
        load_library(GOOD)


def test_compiler_that_rejects_all_code_does_not_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As one does whose headers are missing, or that is for another language; the code is good."""
    own = 'for part; do case $part in *.c) echo "$part:1:1: error: wrong" >&2; exit 1;; esac; done'
    choose_compiler(monkeypatch, tmp_path / "own-compiler", own)
    with pytest.raises(CompilerError, match=r"own-compiler failed: .*generated\.c:1:1: error: wrong"):
        load_library(GOOD)


def test_compiler_that_is_killed_does_not_work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    own = 'case "$*" in *generated.c*) echo "fatal error: killed" >&2; exit 1;; esac'
    choose_compiler(monkeypatch, tmp_path / "own-compiler", own)
    with pytest.raises(CompilerError, match="own-compiler failed: fatal error: killed"):
        load_library(GOOD)
