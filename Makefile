# modelcast: `make demo`, `make demo-live` and `make test` are all a newcomer needs; each creates .venv by themselves.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin


.PHONY: demo demo-live docs screenshots test test-only verify check lint types bench bench-paired mutate fuzz figures paper validate soak setup setup-dev lock clean same
demo: setup
	$(BIN)/modelcast demo --out out/demo

# Four nodes on this machine, and the page of one of them; DEMO_LIVE_ARGUMENTS="--headless" serves no page.
DEMO_LIVE_ARGUMENTS ?=
demo-live: $(VENV)/.node
	$(BIN)/modelcast demo-live $(DEMO_LIVE_ARGUMENTS)

# The documentation site, out/site/index.html; a broken link, a page in no menu or a docstring that does not parse ends it.
# DOCS_ARGUMENTS are the script's (--out, --base).
docs: $(VENV)/.docs
	$(BIN)/python tools/website/build.py $(DOCS_ARGUMENTS)

# Pictures of a report, of the site and of the live page, on a phone and on a desk; those that pages show, into docs/images.
# SCREENSHOTS_ARGUMENTS are the script's (a folder, --only, --report, --site, --every, --write).
SCREENSHOTS_ARGUMENTS ?= out/screenshots --write
screenshots: setup-dev
	$(BIN)/python tools/page_screenshots.py $(SCREENSHOTS_ARGUMENTS)

# Bytecode is kept whatever the environment says: tests start hundreds of interpreters, most of which would else be
# compiling modelcast's sources. pyright is one process that waits for nobody, so it runs beside the tests.
test verify: export PYTHONDONTWRITEBYTECODE :=
test: lint
	$(MAKE) --no-print-directory --jobs=2 types test-only

test-only: setup-dev
	$(BIN)/python -m pytest -n auto --dist worksteal --junitxml=out/test-times.xml

# What is slow: a wheel installed, upgraded and run, processes that race on a cold cache.
verify: setup-dev
	$(BIN)/python -m pytest -n auto --dist worksteal -m slow tests

check: lint types

lint: setup-dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/lint-imports

types: setup-dev
	$(BIN)/pyright

# What was measured goes into benchmarks/results.json, benchmark by benchmark, and from there into docs/performance.md.
bench: setup-dev
	$(BIN)/python benchmarks/run_all.py $(BENCH_ARGUMENTS); ended=$$?; \
	$(BIN)/python benchmarks/performance_page.py --write && exit $$ended

# How much faster HEAD is than BASE, each a folder or a revision; PAIRED_ARGUMENTS are the script's (--only, --rounds, --limit).
BASE ?= main
HEAD ?= .
bench-paired: setup-dev
	$(BIN)/python benchmarks/paired.py $(BASE) $(HEAD) $(PAIRED_ARGUMENTS)

# Whether the tests notice a changed rule: an hour on two cores at most, less where little changed since the last run.
MUTATE_ARGUMENTS ?= --minutes 60
mutate: setup-dev
	$(BIN)/python tools/mutate.py $(MUTATE_ARGUMENTS)

# A minute of profiles and run files, then ten million inputs; FUZZ_ARGUMENTS are libFuzzer's. What it finds is kept in out/fuzz.
FUZZ_ARGUMENTS ?= -runs=10000000 -max_len=4096
fuzz: setup
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements-fuzz.lock
	mkdir -p out/fuzz/corpus
	$(BIN)/python -W ignore fuzz/profiles.py --seconds 60 --keep out/fuzz
	$(BIN)/python fuzz/run.py out/fuzz/corpus fuzz/corpus -artifact_prefix=out/fuzz/ $(FUZZ_ARGUMENTS)

# Needs the folder of reference figures in MODELCAST_REFERENCE, and in MODELCAST_NS3_PYTHON an interpreter that has
# pip's ns3 3.44; what is not named is skipped.
validate: setup-dev
	$(if $(MODELCAST_REFERENCE),$(BIN)/python validation/wilab.py)
	$(if $(MODELCAST_REFERENCE),$(BIN)/python validation/wilab_nr.py)
	$(BIN)/python validation/mode4_published.py
	$(if $(MODELCAST_NS3_PYTHON),$(BIN)/python validation/ns3.py)
	$(if $(MODELCAST_NS3_PYTHON),$(BIN)/python validation/ns3_error_tables.py $(MODELCAST_NS3_PYTHON))
	$(if $(MODELCAST_NS3_PYTHON),$(BIN)/python validation/ns3_load.py $(MODELCAST_NS3_PYTHON) --keep out/ns3-load)
	$(if $(MODELCAST_NS3_PYTHON),$(BIN)/python validation/closed_loop_ns3.py out/closed-loop-ns3)

# The tables of README.md and docs that take seconds; FIGURES_ARGUMENTS are the script's: --check compares, --only NAME makes
# others, --list says what makes what, --numbers lists numbers in prose that no table has.
FIGURES_ARGUMENTS ?=
figures: setup-dev
	$(BIN)/python validation/figures.py $(FIGURES_ARGUMENTS)

# docs/paper.md, and the paper's blocks of README.md and docs/results.md; needs MODELCAST_DATA.
paper: setup-dev
	$(BIN)/python validation/paper.py $(PAPER_ARGUMENTS)

# What is evaluated, simulated and driven is the same: every trip of the data folder, byte for byte; hours on two cores.
# SAME_ARGUMENTS="--most 3" takes three trips of each source.
SAME_ARGUMENTS ?=
same: setup-dev
	$(BIN)/python validation/same.py $(SAME_ARGUMENTS)

# What nodes do when things go wrong, ten minutes, on this machine's loopback interface; SOAK_ARGUMENTS are the script's
# (--short, --minutes, --only, --write).
SOAK_ARGUMENTS ?=
soak: setup-dev
	$(BIN)/python validation/soak.py $(SOAK_ARGUMENTS)

setup: $(VENV)/.runtime
setup-dev: $(VENV)/.dev

$(VENV)/.runtime: requirements.lock pyproject.toml
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation -e .
	touch $@

$(VENV)/.dev: requirements-dev.lock $(VENV)/.runtime
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements-dev.lock
	touch $@

$(VENV)/.node: requirements-node.lock $(VENV)/.runtime
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements-node.lock
	touch $@

$(VENV)/.docs: requirements-docs.lock $(VENV)/.runtime
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements-docs.lock
	touch $@

# Needs uv; nothing else here does.
lock:
	uv pip compile --universal --python-version 3.11 --generate-hashes --no-annotate --no-header \
		pyproject.toml --group build --extra network -o requirements.lock
	uv pip compile --universal --python-version 3.11 --generate-hashes --no-annotate --no-header \
		pyproject.toml --group dev -o requirements-dev.lock
	uv pip compile --universal --python-version 3.11 --generate-hashes --no-annotate --no-header \
		pyproject.toml --group fuzz -o requirements-fuzz.lock
	uv pip compile --universal --python-version 3.11 --generate-hashes --no-annotate --no-header \
		pyproject.toml --group build --extra network --extra node -c requirements-dev.lock -o requirements-node.lock
	uv pip compile --universal --python-version 3.11 --generate-hashes --no-annotate --no-header \
		pyproject.toml --group build --group docs --extra network --extra node -c requirements-dev.lock -o requirements-docs.lock

clean:
	rm -rf $(VENV) out build dist
