# `make` sets up .venv and runs the workflow. Snakemake stays in the open: everything beyond the
# default run is `.venv/bin/snakemake ...`. Written for GNU make 3.81 (the one of macOS) and newer.
# `make help` lists all targets. Those that are seldom typed are in make/.

.DEFAULT_GOAL := all
.DELETE_ON_ERROR:

include make/venv.mk

# What `make nightly` and `make verify` make; choose another one with `make verify CAMPAIGN=...`.
CAMPAIGN ?= demo
PYTEST = $(IN_VENV) $(BIN)/pytest --numprocesses logical --maxprocesses 4 --dist loadfile --no-loadscope-reorder
# A warning is an error; all of them are shown.
SPHINX := --fail-on-warning --keep-going --nitpicky --quiet --fresh-env

.PHONY: all setup dev test lint lint-types lint-rest docs nightly clean help

all: $(READY) ## set up .venv, then run the default campaign (snakemake)
	@$(IN_VENV) $(BIN)/snakemake

setup: $(READY) ## set up .venv only

dev: $(DEV) ## the same, with what tests and checks need

test: lint ## every static check, then the quick tests (3 min); SLOW=yes: the slow ones, too (10 min)
	$(PYTEST) $(if $(SLOW),,-m "not slow and not nightly")

lint: $(DEV) ## every static check: style, format, types, imports, workflow
	@$(MAKE) --no-print-directory -j 2 lint-types lint-rest

# Types without a cache take as long as all the rest, so they go beside it.
lint-types: $(DEV)
	$(BIN)/mypy

lint-rest: $(DEV)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/lint-imports --no-logo
	$(BIN)/snakefmt --check Snakefile workflow
	$(IN_VENV) $(BIN)/snakemake --lint
	$(BIN)/python tests/lint/licences.py
	$(BIN)/check-jsonschema --builtin-schema vendor.github-workflows .github/workflows/*.yml

docs: $(DOCS) ## the documentation as a site in docs/_build/html, without a network (a minute)
	$(IN_VENV) $(BIN)/sphinx-build $(SPHINX) --builder html docs docs/_build/html

nightly: $(DEV) $(DOCS) audit ## what audit says, long tests, then the pinned campaign anew: release, drift gate, rebuild (20 min)
	$(IN_VENV) $(BIN)/pytest -m "nightly or hypothesis" --hypothesis-profile nightly
	$(IN_VENV) $(BIN)/snakemake release --config campaign=$(CAMPAIGN)
	$(IN_VENV) $(BIN)/oilfilm diff data/reference/pins/$(CAMPAIGN) results/releases/$(CAMPAIGN)/latest --gate
	$(IN_VENV) $(BIN)/oilfilm verify results/releases/$(CAMPAIGN)/latest --rebuild
	@$(MAKE) --no-print-directory findings

clean: ## remove .venv and caches; data/, results/ and .snakemake/ stay
	rm -rf $(VENV) .venv-* .import_linter_cache .mypy_cache .pytest_cache .ruff_cache .hypothesis htmlcov .coverage .coverage.*
	find workflow tests -type d -name __pycache__ -prune -exec rm -rf {} +

help: ## this list
	@awk 'BEGIN {FS = ":.*## "} /^[a-z-]+:.*## / {printf "make %-13s %s\n", $$1, $$2}' Makefile make/*.mk

include make/bench.mk make/checks.mk make/renew.mk
