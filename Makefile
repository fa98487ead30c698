# Everything installs itself into .venv at the versions of constraints.txt.

PYTHON ?= $(shell command -v python3.11 || command -v python3)
VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt

# `source .venv/bin/activate` puts the prp-gym and python of this environment on the path.
.PHONY: install evaluate reproduce test mutants lint type bench peers clients docs frames sweep train compare clean

install: $(VENV)/.core

evaluate: $(VENV)/.core
	$(BIN)/prp-gym evaluate

reproduce: $(VENV)/.core
	$(BIN)/prp-gym reproduce

test: $(VENV)/.dev
	$(BIN)/python -m pytest -n auto --dist worksteal

mutants: $(VENV)/.dev
	$(BIN)/python -m bench.mutants

lint: $(VENV)/.dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

type: $(VENV)/.dev
	$(BIN)/mypy

bench: $(VENV)/.dev peers
	$(BIN)/python -m bench

peers: $(VENV)/.dev
	$(BIN)/python -m bench.peers

clients: $(VENV)/.dev
	$(BIN)/python -m bench.clients

train: $(VENV)/.agents
	$(BIN)/prp-gym train --shipped
	$(BIN)/prp-gym ship

compare: $(VENV)/.core
	$(BIN)/prp-gym compare

sweep: $(VENV)/.dev
	$(BIN)/python -m bench.sweep_gains

docs: $(VENV)/.dev
	$(BIN)/python -m docs.generate

frames: $(VENV)/.dev
	$(BIN)/python -m docs.frames

clean:
	rm -rf $(VENV) .venv-peers .venv-clients build dist *.egg-info .mypy_cache .pytest_cache .ruff_cache .hypothesis results comparison

$(VENV)/.core: pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "prp_gym needs Python 3.11 or newer; this is $$($(PYTHON) --version). Set PYTHON=..."; exit 1; }
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(PIP) --editable .
	@touch $@

$(VENV)/.agents: $(VENV)/.core
	$(PIP) --editable '.[agents]'
	@touch $@

$(VENV)/.dev: $(VENV)/.core
	$(PIP) --editable '.[dev]'
	@touch $@
