"""Tests of compiled code are skipped where there is no C compiler; some lose it, or have another."""

import importlib.util
import stat
from pathlib import Path

import pytest

from prp_gym.errors import CompilerError
from prp_gym.symbolic.compiler import find_compiler, load_library


def _is_missing() -> bool:
    try:
        find_compiler()
    except CompilerError:
        return True
    return False


needs_compiler = pytest.mark.skipif(_is_missing(), reason="no C compiler on this machine")


def forget_compiler() -> None:
    """Nothing is known of a compiler or of libraries, as in a new process."""
    find_compiler.cache_clear()
    load_library.cache_clear()


def lose_compiler(monkeypatch: pytest.MonkeyPatch) -> None:
    """No compiler is found."""
    monkeypatch.setenv("PATH", "")
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setattr(importlib.util, "find_spec", lambda _: None)
    forget_compiler()


def write_program(path: Path, text: str) -> Path:
    """A program of the shell that can be run."""
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return path


def choose_compiler(monkeypatch: pytest.MonkeyPatch, path: Path, text: str) -> None:
    """The compiler is a program of the shell, which is written."""
    monkeypatch.setenv("CC", str(write_program(path, text)))
    forget_compiler()
