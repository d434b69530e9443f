# Two commands do everything on a fresh machine: `make demo` and `make test`.
VENV := .venv
BIN := $(VENV)/bin
MARK := $(VENV)/.installed
# PyBullet has wheels for Python 3.11 and earlier only, so 3.11 is looked for first.
PYTHON ?= $(shell command -v python3.11 || command -v python3 || command -v python)

PARALLEL := --numprocesses auto --dist loadfile --no-loadscope-reorder

# Where it is set, each of the hundreds of processes that the tests start would translate the sources anew.
test test-fast coverage: export PYTHONDONTWRITEBYTECODE :=

.PHONY: demo test test-fast check coverage bench bench-release fuzz picture docs clean

demo: $(MARK)-sim
	$(BIN)/rectbench demo -o demo --force

# The kernels are compiled once for all processes of the tests, which take a file of tests each.
# In their own order: else the files with the fewest tests, which take longest, come last and one process waits.
test: $(MARK)-all
	$(BIN)/rectmerge warm-up --quiet
	$(BIN)/python -m pytest $(PARALLEL) --durations=25

test-fast: $(MARK)-all
	$(BIN)/rectmerge warm-up --quiet
	$(BIN)/python -m pytest $(PARALLEL) -m "not slow and not sim and not real" --hypothesis-profile=fast

check: $(MARK)-all
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

# Times as ratios to a yardstick of the same run, against the latest release's; on a quiet machine.
bench: $(MARK)-all
	$(BIN)/python -m pytest tests/bench -o python_files="bench_*.py" --benchmark-only --benchmark-columns=min,median,rounds --benchmark-json=bench.json
	$(BIN)/python -m tests.bench.ratios save bench.json bench-ratios.json
	@latest=$$(ls results/bench/*.json 2>/dev/null | sort -V | tail -1); test -z "$$latest" || $(BIN)/python -m tests.bench.ratios compare bench-ratios.json "$$latest"

bench-release: bench
	cp bench-ratios.json results/bench/$$($(BIN)/python -c 'import rectmerge; print(rectmerge.__version__)').json

# The whole of the tests with the branches they take; fails below what pyproject.toml says.
coverage: $(MARK)-all
	$(BIN)/python -m pytest --cov --cov-report=term --durations=25

# Random and hostile maps and files for some ten minutes; `make test` tries a few of each.
fuzz: $(MARK)-all
	$(BIN)/python -m pytest tests/fuzz -p no:cacheprovider --hypothesis-profile=long

include results/pages.mk

# The README's picture, the demo's, and those of docs/how-it-works.md and docs/the-papers-method.md, small enough to be kept.
picture: demo
	$(BIN)/python -c 'from PIL import Image; p = Image.open("demo/demo.png"); p.thumbnail((1280, 1280)); p.quantize(128, method=1, dither=0).save("docs/demo.png", optimize=True)'
	$(BIN)/rectbench explain -o docs/how-it-works --force
	$(BIN)/rectbench figures -o docs/the-papers-method --force

# The documentation as a site in site/; the page of commands is made anew.
docs: $(MARK)-all
	$(BIN)/python -m scenarios.cli.docs_page > docs/commands.md
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet

clean:
	rm -rf $(VENV) demo build dist site

# Marked when done, so that what was interrupted is made again.
$(VENV)/.made:
	@test -n "$(PYTHON)" || { echo "no Python found: install Python 3.11 with its venv module (Debian: apt install python3.11-venv), then run make again" >&2; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info[:2] != (3, 11))' 2>/dev/null || { echo "$(PYTHON) is $$($(PYTHON) -V 2>&1), but PyBullet has wheels for Python 3.11 only: install that, or name it with make PYTHON=/path/to/python3.11 (rectmerge alone, without the simulation, runs on later ones: pip install .)" >&2; exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || { echo "$(PYTHON) cannot make virtual environments: install its venv module (Debian: apt install python3.11-venv), then run make again" >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)
	@touch $@

# One mark per set of extras; uv installs faster where it is there and can, pip does it everywhere.
$(MARK)-sim: EXTRAS := sim
$(MARK)-all: EXTRAS := sim,bench,ros,live,dev
$(MARK)-sim $(MARK)-all: pyproject.toml $(VENV)/.made
	@echo "installing rectmerge[$(EXTRAS)] into $(VENV) ..."
	@{ command -v uv >/dev/null && uv pip install --quiet --python $(BIN)/python -e ".[$(EXTRAS)]"; } \
	|| $(BIN)/python -m pip install --quiet --disable-pip-version-check -e ".[$(EXTRAS)]"
	@touch $@
