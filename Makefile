# Everything runs in a virtual environment of its own, made here from requirements.lock (names and versions).
# --no-compile: most of what is installed is never imported, and byte-compiling all of it doubles the time.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
INSTALL := $(BIN)/python -m pip install --no-compile --quiet --disable-pip-version-check -c requirements.lock

# Where the environment forbids it, every process of the tests would byte-compile the libraries it imports again.
export PYTHONDONTWRITEBYTECODE :=

.PHONY: inspect climb test types pytest test-long bench docs clean

# Set up and run the main job: plan, simulate and report the inspection of a bay of a real-sized bridge.
inspect: $(VENV)/ready
	$(BIN)/steeplejack inspect ecs620-like --fan T1L-main --stays 5:9 --from-m 20 --to-m 53.3 --out out

# Set up and run the pipe climber's main job: plan, simulate and report the climb of a vertical pipe.
climb: $(VENV)/ready
	$(BIN)/steeplejack climb straight-vertical --out out

# What CI runs: style, the docs, types, layering, tests. The type checker has one thread: the tests run beside it.
test: $(VENV)/ready-dev
	$(BIN)/ruff check src tests benchmarks examples
	$(BIN)/ruff format --check src tests benchmarks examples
	$(BIN)/mkdocs build --strict --quiet
	$(MAKE) --no-print-directory -j 2 types pytest

types: $(VENV)/ready-dev
	$(BIN)/basedpyright --pythonpath $(BIN)/python

# Most of the tests' time is compiling kernels: tests/conftest.py keeps those that share them with one worker, and they
# are optimised less than what users run.
pytest: $(VENV)/ready-dev
	NUMBA_OPT=1 $(BIN)/python -m pytest -n 2 --dist loadfile

# Every test, the long ones too.
test-long: $(VENV)/ready-dev
	$(BIN)/python -m pytest -n 2 --dist loadfile -m "long or not long"

bench: $(VENV)/ready-dev
	$(BIN)/python benchmarks/planar_map.py
	$(BIN)/python benchmarks/control_step.py
	$(BIN)/python benchmarks/spatial_closure.py
	$(BIN)/python benchmarks/distribution.py
	$(BIN)/python benchmarks/forward.py
	$(BIN)/python benchmarks/certified.py
	$(BIN)/python benchmarks/anchors.py
	$(BIN)/python benchmarks/stances.py
	$(BIN)/python benchmarks/climber_design.py --study
	$(BIN)/python benchmarks/scaling.py
	$(BIN)/python benchmarks/peers.py
	$(BIN)/python benchmarks/climber.py

docs: $(VENV)/ready-dev
	$(BIN)/mkdocs build --strict

$(BIN)/python:
	$(PYTHON) -m venv $(VENV)

$(VENV)/ready: pyproject.toml requirements.lock | $(BIN)/python
	$(INSTALL) -e .
	touch $@

$(VENV)/ready-dev: pyproject.toml requirements.lock | $(BIN)/python
	$(INSTALL) -e ".[dev]"
	touch $(VENV)/ready $@

clean:
	rm -rf $(VENV) out site
