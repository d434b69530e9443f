# Two commands do everything on a fresh machine: `make demo` and `make test`.
VENV := .venv
BIN := $(VENV)/bin
MARK := $(VENV)/.installed
# PyBullet has wheels for Python 3.11 and earlier only, so 3.11 is looked for first.
PYTHON ?= $(shell command -v python3.11 || command -v python3 || command -v python)

.PHONY: demo test test-fast check bench clean

demo: $(MARK)-sim
	$(BIN)/rectbench demo -o demo --force

test: $(MARK)-all
	$(BIN)/python -m pytest

test-fast: $(MARK)-all
	$(BIN)/python -m pytest -m "not slow and not sim"

check: $(MARK)-all
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

bench: $(MARK)-all
	$(BIN)/python -m pytest tests/bench -o python_files="bench_*.py" --benchmark-only

clean:
	rm -rf $(VENV) demo build dist

$(VENV):
	@test -n "$(PYTHON)" || { echo "no Python found: install Python 3.11 with its venv module (Debian: apt install python3.11-venv), then run make again" >&2; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info[:2] != (3, 11))' || { echo "$(PYTHON) is $$($(PYTHON) -V 2>&1), but PyBullet has wheels for Python 3.11: install it, or name it with make PYTHON=/path/to/python3.11" >&2; exit 1; }
	@$(PYTHON) -c 'import ensurepip' 2>/dev/null || { echo "$(PYTHON) cannot make virtual environments: install its venv module (Debian: apt install python3.11-venv)" >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)

# One mark per set of extras; uv installs faster where it is there, pip does it everywhere.
$(MARK)-sim: EXTRAS := sim
$(MARK)-all: EXTRAS := sim,bench,ros,dev
$(MARK)-sim $(MARK)-all: pyproject.toml | $(VENV)
	@echo "installing rectmerge[$(EXTRAS)] into $(VENV) ..."
	@if command -v uv >/dev/null; then uv pip install --quiet --python $(BIN)/python -e ".[$(EXTRAS)]"; \
	else $(BIN)/python -m pip install --quiet --disable-pip-version-check -e ".[$(EXTRAS)]"; fi
	@touch $@
