"""The compiler and its cache: compiled once, usable without a cache folder, clear where nothing compiles."""

import importlib.util
import os
import platform
import stat
from collections.abc import Iterator
from pathlib import Path

import pytest

from prp_gym.errors import CompilerError, GeneratedCodeError
from prp_gym.symbolic import compiler
from prp_gym.symbolic.compiler import (
    build_library,
    cache_folder,
    compiles_by_default,
    find_compiler,
    library_name,
    load_library,
    loaded_sources,
    require_compiled_code,
)
from tests.support.compiler import forget_compiler, lose_compiler, write_program
from tests.symbolic.compilation import require_compiler

FOUR = "int four(void) { return 4; }\n"
FIVE = "int five(void) { return 5; }\n"


@pytest.fixture(autouse=True)
def new_process() -> Iterator[None]:
    """Nothing is known of a compiler or of libraries, before and after a test."""
    forget_compiler()
    yield
    forget_compiler()


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder for compiled libraries, and a compiler."""
    require_compiler()
    monkeypatch.setenv("PRP_GYM_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "temporary"))
    (tmp_path / "temporary").mkdir()
    return tmp_path / "cache"


@pytest.fixture
def packaged(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of the package's libraries, which has none yet."""
    packaged = folder.with_name("packaged")
    packaged.mkdir()
    monkeypatch.setattr(compiler, "PREBUILT", packaged)
    return packaged


def refuse_to_compile(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(command: list[str]) -> None:
        pytest.fail(f"compiled with {command}")

    monkeypatch.setattr(compiler, "_run", refuse)


def files(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir()) if folder.is_dir() else []


def test_library_is_compiled_once_and_then_taken_from_the_cache(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert load_library(FOUR).four() == 4
    assert [Path(name).suffix for name in files(folder)] == [".so"]  # nothing else is left behind
    load_library.cache_clear()
    refuse_to_compile(monkeypatch)
    assert load_library(FOUR).four() == 4


def test_library_is_loaded_once_in_a_process(folder: Path) -> None:
    assert load_library(FOUR) is load_library(FOUR)


def test_every_source_has_a_library_of_its_own(folder: Path) -> None:
    assert (load_library(FOUR).four(), load_library(FIVE).five()) == (4, 5)
    assert len(files(folder)) == 2


def test_library_of_other_flags_is_another_one(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    load_library(FOUR)
    load_library.cache_clear()
    monkeypatch.setattr(compiler, "FLAGS", (*compiler.FLAGS, "-O1"))
    load_library(FOUR)
    assert len(files(folder)) == 2


def test_library_of_another_kind_of_machine_is_another_one(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Machines of several kinds may share a home folder."""
    load_library(FOUR)
    load_library.cache_clear()
    monkeypatch.setattr(platform, "machine", lambda: "another")
    load_library(FOUR)
    assert len(files(folder)) == 2


def test_damaged_library_is_compiled_anew(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    load_library(FOUR)
    (name,) = files(folder)
    another = folder.with_name("another")  # the system would give the loaded library for the same path
    another.mkdir()
    (another / name).write_bytes(b"half")
    monkeypatch.setenv("PRP_GYM_CACHE", str(another))
    load_library.cache_clear()
    assert load_library(FOUR).four() == 4


def test_file_in_place_of_the_cache_folder_does_no_harm(folder: Path) -> None:
    folder.write_text("a file")
    assert load_library(FOUR).four() == 4
    assert folder.read_text() == "a file"


def test_folder_name_that_the_system_refuses_does_no_harm(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PRP_GYM_CACHE", str(folder / ("x" * 5000)))
    assert load_library(FOUR).four() == 4


def test_folder_that_may_not_be_written_does_no_harm(folder: Path) -> None:
    folder.mkdir()
    folder.chmod(stat.S_IRUSR | stat.S_IXUSR)
    try:
        assert load_library(FOUR).four() == 4
    finally:
        folder.chmod(stat.S_IRWXU)


def test_folder_that_may_not_be_searched_does_no_harm(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The superuser may search every folder, so that the refusal is staged."""
    folder.mkdir()
    original = os.stat

    def refuse(path: object, *arguments: object, **options: object) -> os.stat_result:
        if str(path).startswith(str(folder)):
            raise PermissionError(13, "Permission denied", str(path))
        return original(path, *arguments, **options)  # type: ignore[arg-type]

    monkeypatch.setattr(os, "stat", refuse)
    assert load_library(FOUR).four() == 4


def test_user_without_home_folder_has_a_cache_all_the_same(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In a container a user may have none."""
    for name in ("PRP_GYM_CACHE", "XDG_CACHE_HOME", "HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(os.path, "expanduser", lambda path: path)
    assert load_library(FOUR).four() == 4


def test_temporary_library_is_not_left_behind(folder: Path) -> None:
    """Where there is no cache, nothing piles up in the folder of temporary files."""
    folder.write_text("a file")
    load_library(FOUR)
    assert files(folder.parent / "temporary") == []


@pytest.mark.parametrize(
    ("variables", "expected"),
    [
        ({"PRP_GYM_CACHE": "/given", "XDG_CACHE_HOME": "/xdg", "HOME": "/home/user"}, "/given"),
        ({"XDG_CACHE_HOME": "/xdg", "HOME": "/home/user"}, "/xdg/prp_gym"),
        ({"HOME": "/home/user"}, "/home/user/.cache/prp_gym"),
        ({"PRP_GYM_CACHE": "", "XDG_CACHE_HOME": "", "HOME": "/home/user"}, "/home/user/.cache/prp_gym"),
    ],
)
def test_cache_folder_is_the_users_unless_another_is_given(
    variables: dict[str, str], expected: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("PRP_GYM_CACHE", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    assert cache_folder() == Path(expected)


def test_compiler_that_is_missing_is_said_with_what_to_install(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lose_compiler(monkeypatch)
    with pytest.raises(CompilerError, match="install gcc or clang, or: pip install ziglang"):
        load_library(FOUR)


def test_compiler_of_the_package_ziglang_is_the_last_one(monkeypatch: pytest.MonkeyPatch) -> None:
    lose_compiler(monkeypatch)
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: name)
    assert find_compiler()[1:] == ("-m", "ziglang", "cc")


def test_given_compiler_comes_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    own = write_program(tmp_path / "own-compiler", "exit 0")
    monkeypatch.setenv("CC", str(own))
    assert find_compiler() == (str(own),)


def test_given_compiler_may_have_arguments(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    own = write_program(tmp_path / "own-compiler", "exit 0")
    monkeypatch.setenv("CC", f"{own} -m64")
    assert find_compiler() == (str(own), "-m64")


def test_compiler_that_cannot_run_is_said(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    own = tmp_path / "own-compiler"
    write_program(own, "")
    own.write_text("#!/no/such/program\n")
    monkeypatch.setenv("CC", str(own))
    forget_compiler()
    with pytest.raises(CompilerError, match="own-compiler could not run"):
        load_library(FOUR)


def test_compiler_that_takes_too_long_is_said(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CC", str(write_program(tmp_path / "own-compiler", "exec sleep 60")))
    monkeypatch.setattr(compiler, "_SECONDS", 0.05)
    forget_compiler()
    with pytest.raises(CompilerError, match="own-compiler could not run"):
        load_library(FOUR)


def test_library_of_the_package_needs_neither_compiler_nor_cache(
    folder: Path, packaged: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    built = build_library(FOUR, packaged)
    assert files(packaged) == [built.name]
    lose_compiler(monkeypatch)
    assert load_library(FOUR).four() == 4
    assert files(folder) == []


def test_library_of_the_package_comes_first(
    folder: Path, packaged: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    build_library(FOUR, packaged)
    refuse_to_compile(monkeypatch)
    assert load_library(FOUR).four() == 4
    assert files(folder) == []


def test_name_of_a_library_of_the_package_is_that_of_any_compiler(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    names = {library_name(FOUR)}
    monkeypatch.setenv("CC", str(write_program(tmp_path / "own-compiler", "exit 0")))
    forget_compiler()
    assert {*names, library_name(FOUR)} == names
    assert library_name(FOUR, find_compiler()) not in names
    assert library_name(FIVE) not in names


def test_library_of_the_package_that_cannot_be_loaded_is_compiled(folder: Path, packaged: Path) -> None:
    """It may be damaged, or need another C library."""
    (packaged / library_name(FOUR)).write_bytes(b"half")
    assert load_library(FOUR).four() == 4
    assert len(files(folder)) == 1


def test_library_that_neither_the_package_nor_a_compiler_gives_is_refused(
    packaged: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    build_library(FOUR, packaged)
    lose_compiler(monkeypatch)
    with pytest.raises(CompilerError, match="install gcc or clang"):
        load_library(FIVE)


def test_compiled_code_is_there_with_libraries_of_the_package(
    packaged: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("PRP_GYM_COMPILED", raising=False)
    lose_compiler(monkeypatch)
    assert not compiles_by_default()
    with pytest.raises(CompilerError, match="none was found"):
        require_compiled_code()
    (packaged / library_name(FOUR)).touch()
    require_compiled_code()
    assert compiles_by_default()
    monkeypatch.setenv("PRP_GYM_COMPILED", "0")
    assert not compiles_by_default()


def test_loaded_sources_are_known_once_each(folder: Path) -> None:
    own = "int own_number(void) { return 6; }\n"
    for source in (own, FOUR, own):
        load_library.cache_clear()
        load_library(source)
    assert loaded_sources().count(own) == 1
    without = "int another_number(void) { return }\n"
    with pytest.raises(GeneratedCodeError):
        load_library(without)
    assert without not in loaded_sources()
