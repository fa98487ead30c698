# Everything installs itself into .venv at the versions of constraints.txt.

PYTHON ?= $(shell command -v python3.11 || command -v python3)
VENV := .venv
BIN := $(VENV)/bin
LOWEST := .venv-lowest
# What depends on the versions of other packages; the rest tests this package's own files, commands and pages.
LOWEST_TESTS ?= tests/action_modes tests/agents tests/baselines tests/conformance/test_environments.py \
	tests/conformance/test_registration.py tests/conformance/test_vector_wrappers.py \
	tests/conformance/test_wrappers.py tests/core tests/envs tests/evaluation tests/physics tests/robot \
	tests/runs tests/tasks tests/tuning
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile -c constraints.txt
# Bytecode of all packages, on all cores, where pip takes one; some have files for other versions of Python.
COMPILE := $(BIN)/python -m compileall -qq -j 0 $(VENV)/lib || true

# `source .venv/bin/activate` puts the prp-gym and python of this environment on the path.
.PHONY: install evaluate reproduce test test-lowest mutants mutants-reproduce fuzz kills clients lint type bench \
        peers docs frames bench-engines bench-agreement wheel tune train compare audit learn-check first-ten-minutes clean

install: $(VENV)/.core

evaluate: $(VENV)/.core
	$(BIN)/prp-gym evaluate

reproduce: $(VENV)/.core
	$(BIN)/prp-gym reproduce

# Tests start this package's commands a hundred times; with bytecode they need not compile it each time.
test: $(VENV)/.dev
	PYTHONDONTWRITEBYTECODE= $(BIN)/python -m pytest -n auto --dist worksteal

test-lowest: $(LOWEST)/.tests
	$(LOWEST)/bin/python -m pytest $(LOWEST_TESTS)

mutants: $(VENV)/.dev
	$(BIN)/python -m bench.mutants

mutants-reproduce: $(VENV)/.dev
	$(BIN)/python -m bench.mutants_reproduce

fuzz: $(VENV)/.dev
	$(BIN)/python -m bench.fuzz $(FUZZ)

kills: $(VENV)/.dev
	$(BIN)/python -m bench.kills
	$(BIN)/python -m bench.orphans

lint: $(VENV)/.dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

type: $(VENV)/.dev
	$(BIN)/mypy

# Follows README's commands in a new clone of this repository, whose packages it downloads.
first-ten-minutes: $(VENV)/.core
	$(BIN)/python -m bench.first_ten_minutes

bench: $(VENV)/.dev peers
	$(BIN)/python -m bench
	$(BIN)/python -m bench.engines

bench-engines: $(VENV)/.dev
	$(BIN)/python -m bench.engines

bench-agreement: $(VENV)/.dev
	$(BIN)/python -m bench.agreement

# The compiled code of the wheel is for machines like this one, with or without a compiler.
wheel: $(VENV)/.dev
	rm -rf build
	$(BIN)/python -m prp_gym.prebuilding --output build/libraries
	PRP_GYM_LIBRARIES=$(CURDIR)/build/libraries $(BIN)/python -m build --no-isolation --wheel

peers: $(VENV)/.dev
	$(BIN)/python -m bench.peers

clients: $(VENV)/.dev
	$(BIN)/python -m bench.clients

learn-check: $(VENV)/.dev
	$(BIN)/python -m bench.learn_check $(LEARN)
	$(BIN)/python -m docs.generate

train: $(VENV)/.agents
	$(BIN)/prp-gym train --shipped --output runs
	$(BIN)/prp-gym ship --runs runs

compare: $(VENV)/.core
	$(BIN)/prp-gym compare --output comparison

# The stored summary is the one that docs/audit.md shows.
audit: $(VENV)/.dev
	$(BIN)/prp-gym audit --output audit $(AUDIT); status=$$?; \
	$(BIN)/python -m docs.audit_page audit/results.json && exit $$status

tune: $(VENV)/.core
	$(PIP) --editable '.[tune]'
	$(COMPILE)
	$(BIN)/prp-gym tune-all --output tuning $(TUNE)
	$(BIN)/prp-gym ship-gains --searches tuning

docs: $(VENV)/.dev
	$(BIN)/python -m docs.generate

frames: $(VENV)/.dev
	$(BIN)/python -m docs.frames
	$(BIN)/python -m docs.page_frames

clean:
	rm -rf $(VENV) $(LOWEST) .venv-peers .venv-clients build dist *.egg-info .mypy_cache .pytest_cache .ruff_cache \
	    .hypothesis results comparison

$(VENV)/.core: pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "prp_gym needs Python 3.11 or newer; this is $$($(PYTHON) --version). Set PYTHON=..."; exit 1; }
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(PIP) --editable .
	$(COMPILE)
	@touch $@

$(VENV)/.agents: $(VENV)/.core
	$(PIP) --editable '.[agents]'
	$(COMPILE)
	@touch $@

$(VENV)/.dev: $(VENV)/.core
	$(PIP) --editable '.[dev]'
	$(COMPILE)
	@touch $@

# The lowest declared version of every dependency; what these need is taken at its newest version.
$(LOWEST)/.tests: pyproject.toml tests/support/lowest_versions.py
	rm -rf $(LOWEST)
	$(PYTHON) -m venv $(LOWEST)
	$(PYTHON) -m tests.support.lowest_versions > $(LOWEST)/constraints.txt
	$(LOWEST)/bin/python -m pip install --quiet --disable-pip-version-check -c $(LOWEST)/constraints.txt \
		--editable . $$(cut -d= -f1 $(LOWEST)/constraints.txt)
	@touch $@
