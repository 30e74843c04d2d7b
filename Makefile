# Every target does the set-up it needs; a second run installs nothing.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
RL_STAMP := $(VENV)/.installed-rl
# Any PyTorch that Stable-Baselines3 takes will do, on the CPU or not.
TORCH ?= torch==2.13.0

.PHONY: demo test test-rl test-train test-bare test-lowest test-newest check format bench clean

demo: $(STAMP)
	$(BIN)/sonarbed demo --out demo

test: $(STAMP)
	$(BIN)/pytest

test-rl: $(RL_STAMP)
	$(BIN)/pytest tests/rl

# The training of the learned mapper, as small as can be.
test-train: $(RL_STAMP)
	$(BIN)/pytest tests/train

# Commands from a wheel that may only be read, for a user without home, display or UTF-8.
test-bare: $(STAMP)
	.ci/bare-user $(VENV)

# The core with the lowest versions that pyproject.toml allows, on the oldest Python.
test-lowest:
	.ci/core-tests $(VENV)-lowest python3.11 lowest

# The core on the newest Python at hand that its dependencies have wheels for.
test-newest:
	.ci/core-tests $(VENV)-newest "$$(.ci/newest-python)" latest

check: $(STAMP)
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy

format: $(STAMP)
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

bench: $(STAMP)
	$(BIN)/python benchmarks/run.py

# The stamp is as new as the last installation that succeeded for this pyproject.toml.
$(STAMP): pyproject.toml
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip
	$(BIN)/python -m pip install --quiet --editable '.[dev]'
	touch $@

$(RL_STAMP): $(STAMP)
	$(BIN)/python -m pip install --quiet '$(TORCH)'
	$(BIN)/python -m pip install --quiet --editable '.[dev,rl]'
	touch $@

clean:
	rm -rf $(VENV) $(VENV)-lowest $(VENV)-newest demo .pytest_cache .mypy_cache .ruff_cache
