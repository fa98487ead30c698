"""Compiling generated C code into a shared library, once for each text and compiler."""

import ctypes
import hashlib
import importlib.util
import os
import shutil
import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path

from prp_gym.errors import CompilerError

FLAGS = ("-O2", "-std=c11", "-fPIC", "-shared", "-ffp-contract=off", "-fno-math-errno")
"""No flag lets the compiler change a result: products and sums are rounded one by one, as in NumPy."""

_SECONDS = 300.0


@cache
def find_compiler() -> tuple[str, ...]:
    """The command of a C compiler: `$CC`, cc, gcc or clang, or that of the package ziglang.

    Raises:
        CompilerError: no compiler was found.
    """
    for name in (os.environ.get("CC", ""), "cc", "gcc", "clang"):
        found = shutil.which(name) if name else None
        if found:
            return (found,)
    if importlib.util.find_spec("ziglang") is not None:
        return sys.executable, "-m", "ziglang", "cc"
    raise CompilerError("none was found: install gcc or clang, or: pip install ziglang")


def cache_folder() -> Path:
    """The folder of compiled libraries: `$PRP_GYM_CACHE`, or `prp_gym` in the user's folder of caches."""
    given = os.environ.get("PRP_GYM_CACHE")
    if given:
        return Path(given)
    base = os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / "prp_gym"


@cache
def load_library(source: str) -> ctypes.CDLL:
    """The shared library of a C source, compiled unless it is in the cache.

    Raises:
        CompilerError: no compiler, or one that refuses the source.
    """
    command = find_compiler()
    key = hashlib.sha256("\0".join((*command, *FLAGS, sys.platform, source)).encode()).hexdigest()[:32]
    path = cache_folder() / f"{key}.so"
    if not path.is_file():
        path = _compile(command, source, path)
    return ctypes.CDLL(str(path))


def _compile(command: tuple[str, ...], source: str, path: Path) -> Path:
    """Compile into a file that appears when it is complete, of the cache or a temporary one."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        folder = Path(tempfile.mkdtemp(dir=path.parent))
    except OSError:  # a read-only home
        folder = Path(tempfile.mkdtemp(prefix="prp_gym-"))
        path = folder.parent / f"{folder.name}.so"
    try:
        text, built = folder / "generated.c", folder / "built.so"
        text.write_text(source, encoding="utf-8")
        _run([*command, *FLAGS, "-o", str(built), str(text), "-lm"])
        os.replace(built, path)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return path


def _run(command: list[str]) -> None:
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=_SECONDS, check=False)
    except (OSError, subprocess.TimeoutExpired) as error:
        raise CompilerError(f"{command[0]} could not run: {error}") from error
    if done.returncode != 0:
        raise CompilerError(f"{command[0]} refused the generated code: {done.stderr[-500:]}")
