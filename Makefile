# Everything starts here: each target sets up what it needs in .venv. PYTHON=python3.12 chooses another interpreter.
PYTHON ?= python3
BIN := .venv/bin
CONSTRAINTS := .ci/constraints.txt
SEED ?= $(shell expr $$(date +%s) / 86400 \* 100000)

.PHONY: demo test check full browser lint docs bench nightly clean

demo: .venv/.runtime ## the whole chain on the built-in hexapod, to hexcite-demo/report.html
	$(BIN)/hexcite demo --overwrite

test: .venv/.dev ## the tests; byte code is kept, for hexcite is started many times
	PYTHONDONTWRITEBYTECODE= $(BIN)/pytest -n auto --dist worksteal -m "not slow and not repeats and not linuxcnc"

check: lint test ## format, lint, types, import contracts, tests

full: check ## check, and what make test leaves out: all variants and examples, and the real LinuxCNC; CI runs it
	PYTHONDONTWRITEBYTECODE= $(BIN)/pytest -n auto --dist worksteal -m "not slow and (repeats or hypothesis or linuxcnc)" --hypothesis-profile full

browser: .venv/.dev ## the guided page in a real Chromium: from machine to certificate, by keyboard, on paper, after kills; CI runs it
	$(BIN)/pytest -n auto --dist worksteal -q -m slow tests/hexcite/page tests/hexcite/test_print.py

lint: .venv/.dev
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-logo

docs: .venv/.dev ## the site docs/_build/index.html; tutorial, notebooks and scripts are run: what they show must be true
	$(BIN)/sphinx-build --quiet --fail-on-warning --keep-going docs docs/_build
	$(BIN)/pytest -q -m slow tests/docs

bench: .venv/.dev ## the figures that matter, measured; minutes, not seconds; BENCH="--save FILE" and "--compare FILE" keep and compare them
	$(BIN)/python -m pytest -m slow -q
	$(BIN)/python tests/bench/figures.py $(BENCH)

.venv/bin/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "hexcite needs Python 3.11 or newer; call make PYTHON=python3.11 ..."; exit 1; }
	$(PYTHON) -m venv .venv
	$(BIN)/pip install --quiet --disable-pip-version-check --upgrade "pip>=25.1"

.venv/.runtime: .venv/bin/python pyproject.toml $(CONSTRAINTS)
	$(BIN)/pip install --quiet --disable-pip-version-check --constraint $(CONSTRAINTS) --editable .
	touch $@

.venv/.dev: .venv/.runtime
	$(BIN)/pip install --quiet --disable-pip-version-check --constraint $(CONSTRAINTS) --group dev
	touch $@

nightly: .venv/.dev ## hours: all slow tests, all kinds of damaged input and accidents, all figures; SEED=n repeats a night
	@status=0; \
	$(BIN)/python -m pytest -m "slow or repeats or hypothesis" --hypothesis-profile full -q || status=1; \
	$(BIN)/python -m tests.bench.reliability.everything --seed $(SEED) || status=1; \
	$(BIN)/python tests/bench/figures.py || status=1; \
	exit $$status

clean:
	rm -rf .venv .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache dist docs/_build hexcite-demo
