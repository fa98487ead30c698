"""Files are read in one package: no other module parses JSON, TOML, YAML or archives by itself."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
MODULES = sorted(
    path.relative_to(ROOT).as_posix()
    for folder in ("prp_gym", "envs", "baselines", "agents")
    for path in (ROOT / folder).rglob("*.py")
)
PARSERS = {
    *("json.load", "json.loads", "tomllib.load", "tomllib.loads", "pickle.load", "pickle.loads"),
    *(
        "yaml.load",
        "yaml.safe_load",
        "np.load",
        "torch.load",
        "zipfile.ZipFile",
        "marshal.loads",
        "eval",
        "exec",
    ),
}
ALLOWED = {
    "prp_gym/files/json_text.py": {"json.loads"},
    "prp_gym/files/toml_text.py": {"tomllib.loads"},
    "prp_gym/files/archive.py": {"zipfile.ZipFile"},
    "agents/training/checkpoint.py": {"np.load", "torch.load"},  # without pickles
    "agents/training/run_export.py": {"np.load", "torch.load"},  # without pickles
    "prp_gym/runs/user_code.py": {"exec"},  # code that the command line names
    "agents/sb3/trusted_files.py": {"pickle.load"},  # with --trust alone
}
"""Calls that a module may make."""


def calls(source: str) -> Iterator[ast.Call]:
    return (node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Call))


@pytest.fixture(scope="module")
def calls_of_modules() -> list[tuple[str, str, ast.Call]]:
    """Module, name of the function and call, of all calls."""
    sources = {name: (ROOT / name).read_text(encoding="utf-8") for name in MODULES}
    return [
        (name, ast.unparse(call.func), call) for name, source in sources.items() for call in calls(source)
    ]


def test_no_module_parses_files_by_itself(calls_of_modules: list[tuple[str, str, ast.Call]]) -> None:
    assert {name for name, _, _ in calls_of_modules} > set(ALLOWED)
    parsing = {(name, function) for name, function, _ in calls_of_modules if function in PARSERS}
    assert {(name, function) for name, function in parsing if function not in ALLOWED.get(name, ())} == set()


def test_arrays_and_weights_are_loaded_without_pickles(
    calls_of_modules: list[tuple[str, str, ast.Call]],
) -> None:
    safe = {"np.load": ("allow_pickle", "False"), "torch.load": ("weights_only", "True")}
    for name, function, call in calls_of_modules:
        if function in safe:
            given = [(item.arg, ast.unparse(item.value)) for item in call.keywords]
            assert safe[function] in given, name


def test_check_sees_a_violation() -> None:
    assert {ast.unparse(call.func) for call in calls("import json\njson.loads(text)")} & PARSERS
