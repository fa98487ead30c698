"""Programs for other libraries: declared, shown in the docs, and run as a user would run them."""

import json
import sys
import venv
from dataclasses import asdict
from pathlib import Path

import pytest

from bench.clients import environment
from bench.clients.catalogue import CLIENTS
from bench.clients.client import Client
from bench.clients.environment import Outcome
from bench.clients.results import RESULTS, read_results, verdict
from docs.clients_page import clients_page

CLIENT = Client("new", "New", "new==1.2", ("torch==2.13.0",), "nothing")


@pytest.mark.parametrize("client", CLIENTS, ids=lambda client: client.name)
def test_client_has_a_pinned_version_a_program_and_a_result(client: Client) -> None:
    assert client.version or not client.library
    text = client.program.read_text(encoding="utf-8")
    assert f"```python\n{text}```" in clients_page()
    assert client.name in read_results()


def test_every_program_has_a_client_and_no_client_fails() -> None:
    programs = set(CLIENTS[0].program.parent.glob("use_*.py"))
    assert programs == {client.program for client in CLIENTS}
    assert {name for name, found in read_results().items() if found.message} == set()


def test_results_are_stored_as_they_were_found() -> None:
    stored = json.loads(RESULTS.read_text(encoding="utf-8"))
    assert stored == {name: asdict(found) for name, found in read_results().items()}


def test_library_alone_is_not_among_the_requirements() -> None:
    assert CLIENT.requirements == ("new==1.2", "torch==2.13.0")
    assert Client("new", "New", "new==1.2", ("a",), "nothing", alone=True).requirements == ("a",)
    assert Client("new", "New", "", ("a",), "nothing").requirements == ("a",)


def test_verdict_is_the_error_or_the_limit() -> None:
    limited = Client("new", "New", "new==1.2", (), "nothing", limit="asks for an older torch")
    assert verdict(CLIENT, Outcome("1.4.0", "", 2.0)) == "unchanged"
    assert verdict(limited, Outcome("1.4.0", "", 2.0)) == "unchanged; its own limit: asks for an older torch"
    assert verdict(limited, Outcome("1.4.0", "ValueError: no", 2.0)) == "ValueError: no"


@pytest.mark.parametrize(
    ("code", "message"), [("print(1)", ""), ("raise ValueError('no')", "ValueError: no")]
)
def test_program_runs_in_a_folder_of_its_own_and_its_last_line_is_kept(
    code: str, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program = tmp_path / "use_new.py"
    program.write_text(f"import prp_gym\nopen('left_behind', 'w').close()\n{code}\n", encoding="utf-8")
    monkeypatch.setattr(Client, "program", program)
    monkeypatch.setattr(environment, "_python", lambda client, folder: sys.executable)
    monkeypatch.chdir(tmp_path)
    found = environment.run(CLIENT, tmp_path)
    assert found.message == message
    assert found.gymnasium
    assert found.seconds > 0.0
    assert [path.name for path in tmp_path.iterdir()] == ["use_new.py"]


def test_installation_that_fails_is_explained_and_tried_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(venv, "create", lambda *_, **__: None)
    for _ in range(2):
        assert "its installation failed" in environment.install(CLIENT, tmp_path / "clients")
    assert not (tmp_path / "clients" / "new.txt").exists()
