# `make` sets up .venv and runs the workflow. Snakemake stays in the open: everything beyond the
# default run is `.venv/bin/snakemake ...`. Written for GNU make 3.81 (the one of macOS) and newer.

VENV := .venv
BIN := $(VENV)/bin

# One stamp for the packages that running needs, one for oilfilm itself, one for the packages of
# the tests: a change of pyproject.toml alone installs nothing twice. Each is touched last, so that
# a half-made .venv never counts as done.
# What a shell, PATH or Snakemake would take for something else (oilfilm/run/start.py says why).
UNUSABLE := $(shell printf %s "$$(pwd -P)" | tr -cd '{}:$$`"\\[:cntrl:]' | tr '[:cntrl:]' '?')
ifneq ($(UNUSABLE),)
$(error The path of this folder has $(UNUSABLE) in it, with which jobs cannot be started. None of { } : $$ ` " \
\ and no control character may be in it. Rename the folder, or move what is in it; blanks and letters do no harm)
endif

# A .venv knows its own path, hence the checksum of the folder: a moved clone is set up again.
PLACE := $(shell pwd -P | cksum | cut -d ' ' -f 1)
LOCKED := $(VENV)/locked-$(PLACE)
READY := $(VENV)/ready-$(PLACE)
DEV := $(VENV)/dev-$(PLACE)
DOCS := $(VENV)/docs-$(PLACE)
# A warning is an error; all of them are shown.
SPHINX := --fail-on-warning --keep-going --nitpicky --quiet --fresh-env

# Choose another one with `make PYTHON=...`. 3.14 comes late because one package behind Snakemake
# has no wheel for it and needs a C compiler; nothing newer has wheels of NumPy in the lock.
PYTHON ?=
PYTHONS = $(or $(PYTHON),python3.13 python3.12 python3.11 python3.14 python3)

# What `make nightly` and `make verify` make; choose another one with `make verify CAMPAIGN=...`.
CAMPAIGN ?= demo

# A name on PATH may be a shim that starts nothing, so each is asked. In an activated .venv the
# answer is the Python behind it, because that .venv is about to be made anew.
FIND_PYTHON = for name in $(PYTHONS); do \
	python=$$("$$name" -c 'import sys; \
	(3, 11) <= sys.version_info[:2] <= (3, 14) or sys.exit(1); \
	print(sys._base_executable)' 2>/dev/null) && break; python=; done

# uv where the user has one; not the one inside .venv, for the same reason.
UV := $(shell PATH="$$(printf %s "$$PATH" | tr : '\n' | grep -vxF "$$PWD/$(BIN)" | paste -sd : -)"; \
	found="$$(command -v uv)" && "$$found" --version >/dev/null 2>&1 && printf %s "$$found")
# Every job starts a Python of its own: without bytecode each would compile pandas anew (1.5 s).
# PIP_USE_PEP517 spares old releases of pip a way of building that setuptools has given up.
INSTALL = $(if $(UV),'$(UV)' pip install --quiet --compile-bytecode --python $(BIN)/python,\
	PIP_USE_PEP517=1 $(BIN)/python -m pip install --quiet --disable-pip-version-check)

# What Snakemake starts must find the same environment first.
# The shell's own PWD, because make would let the shell run what a folder's name may hold.
IN_VENV = PATH="$$PWD/$(BIN):$$PATH"
# Packages of another installation must not shadow the locked ones.
unexport PYTHONPATH PYTHONHOME
# Without bytecode each of many Pythons that are started would compile the library anew.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: all setup dev docs docs-links test coverage lint nightly verify bench-bearing bench-equilibria bench-blind bench-cpu bench-faults bench-fuzz \
	bench-ingest bench-attack bench-refits bench-left-out bench-fit bench-ga bench-coverage bench-mutation bench-plan bench-run bench-scale bench-slurm \
	bench-start lock schemas licences upgrade clean help
.DELETE_ON_ERROR:

all: $(READY) ## set up .venv, then run the default campaign (snakemake)
	@$(IN_VENV) $(BIN)/snakemake

setup: $(READY) ## set up .venv only

dev: $(DEV) ## the same, with what tests and checks need

PYTEST = $(IN_VENV) $(BIN)/pytest --numprocesses logical --maxprocesses 4 --dist loadfile --no-loadscope-reorder

test: lint ## every static check, then the tests
	$(PYTEST)

# Counting lines doubles the time of the tests.
coverage: $(DEV) ## the tests again, with the share of the library's lines that they run (half an hour)
	$(PYTEST) --cov

lint: $(DEV) ## every static check: style, format, types, imports, workflow
	@$(MAKE) --no-print-directory -j 2 lint-types lint-rest

# Types without a cache take as long as all the rest, so they go beside it.
.PHONY: lint-types lint-rest
lint-types: $(DEV)
	$(BIN)/mypy

lint-rest: $(DEV)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/lint-imports --no-logo
	$(BIN)/snakefmt --check Snakefile workflow/Snakefile workflow/rules
	$(IN_VENV) $(BIN)/python tests/lint/snakemake_lint.py
	$(BIN)/python tests/lint/licences.py
	$(BIN)/check-jsonschema --builtin-schema vendor.github-workflows .github/workflows/*.yml

docs: $(DOCS) ## the documentation as a site in docs/_build/html, without a network (a minute)
	$(IN_VENV) $(BIN)/sphinx-build $(SPHINX) --builder html docs docs/_build/html

docs-links: $(DOCS) ## whether the addresses that the documentation names still answer
	$(IN_VENV) $(BIN)/sphinx-build $(SPHINX) --builder linkcheck docs docs/_build/links

nightly: $(DEV) $(DOCS) audit ## what audit says, long tests, then the pinned campaign anew: release, drift gate, rebuild (20 min)
	$(IN_VENV) $(BIN)/pytest -m "nightly or hypothesis" --hypothesis-profile nightly
	$(IN_VENV) $(BIN)/snakemake release --config campaign=$(CAMPAIGN)
	$(IN_VENV) $(BIN)/oilfilm diff data/reference/pins/$(CAMPAIGN) results/releases/$(CAMPAIGN)/latest --gate
	$(IN_VENV) $(BIN)/oilfilm verify results/releases/$(CAMPAIGN)/latest --rebuild
	@$(MAKE) --no-print-directory findings

.PHONY: findings
findings: $(DEV) ## run demo, thermal and etm-slim; are the numbers of README, findings and bearing those of the runs?
	for campaign in demo thermal etm-slim; do $(IN_VENV) $(BIN)/snakemake --config campaign=$$campaign || exit 1; done
	$(IN_VENV) $(BIN)/python tests/helpers/findings.py

verify: $(DEV) ## the demonstration twice, in other surroundings each: the same bytes (10 min)
	$(IN_VENV) $(BIN)/python tests/helpers/reproduce.py $(CAMPAIGN)

OTHER ?= python3.11

.PHONY: verify-python
verify-python: $(DEV) ## the demonstration on this Python and on OTHER=python3.11: the same bytes (10 min)
	@$(MAKE) --no-print-directory VENV=.venv-other PYTHON=$(OTHER) setup
	$(IN_VENV) $(BIN)/python tests/helpers/reproduce.py $(CAMPAIGN) "$$PWD/.venv-other/bin/python"

bench-bearing: $(DEV) ## equilibria of a bearing, one by one and by the thousand (a minute)
	$(BIN)/python benchmarks/bearing.py

bench-equilibria: $(DEV) ## 1 620 light and skidding bearings, alone and together, on the kernels of four CPUs, against MINPACK (an hour)
	$(BIN)/python benchmarks/equilibria.py

bench-faults: $(DEV) ## 30 runs killed at random moments and run again (half an hour)
	$(BIN)/python benchmarks/faults.py 30

bench-run: $(DEV) ## what the workflow costs beside its computing, on the demonstration (15 min)
	$(BIN)/python benchmarks/run.py

bench-slurm: $(DEV) ## the demonstration with and without a Slurm of this machine; as root (25 min)
	$(BIN)/python benchmarks/slurm.py

bench-cpu: $(DEV) ## how far numbers move on other types of CPU (5 min)
	$(BIN)/python benchmarks/cpu_types.py

bench-attack: $(DEV) ## damaged logs, flipped bits, hostile releases, kills: who finds what (an hour)
	$(IN_VENV) $(BIN)/python benchmarks/attack.py

bench-fuzz: $(DEV) ## 20 000 damaged logs: a verdict for each (about half an hour)
	$(BIN)/python benchmarks/fuzz.py 20000

$(LOCKED): requirements/run.lock
	@$(FIND_PYTHON); \
	if [ -z "$$python" ]; then \
		echo "No Python 3.11 to 3.14 was found (tried: $(PYTHONS))." >&2; \
		echo "Install one, or say where it is: make PYTHON=/path/to/python3" >&2; exit 1; \
	fi; \
	if [ -z "$(UV)" ] && ! "$$python" -c 'import ensurepip, venv' 2>/dev/null; then \
		echo "$$python cannot make a virtual environment: its venv module is missing." >&2; \
		echo "Debian and Ubuntu: sudo apt install python3-venv; or put uv on PATH." >&2; exit 1; \
	fi; \
	echo "Setting up $(VENV) from requirements/run.lock: $$python, $(if $(UV),uv,pip (a minute or two))"; \
	rm -rf $(VENV) && \
	$(if $(UV),'$(UV)' venv --quiet --python "$$python" $(VENV),"$$python" -m venv $(VENV))
# Some packages come as source only. They are built with the setuptools of the lock, not with
# whatever is newest today in a build environment that no hash covers.
	@awk '/^[^ ]/ {keep = /^setuptools==/} keep' requirements/run.lock > $(VENV)/setuptools.lock
	@$(INSTALL) --require-hashes --requirement $(VENV)/setuptools.lock
	@$(INSTALL) --require-hashes --no-build-isolation --requirement requirements/run.lock || { \
		echo "The packages of requirements/run.lock could not all be installed; the lines above say why." >&2; \
		echo "On Python 3.14 a C compiler and Python's headers are needed (Debian, Ubuntu: sudo apt" >&2; \
		echo "install build-essential python3-dev; macOS: xcode-select --install); 3.11 to 3.13 need none." >&2; \
		exit 1; }
	@touch $@

$(READY): $(LOCKED) pyproject.toml
	@$(INSTALL) --no-deps --no-build-isolation --editable .
	@touch $@

$(DEV): $(READY) requirements/dev.lock
	@echo "Adding what tests and checks need, from requirements/dev.lock"
	@$(INSTALL) --require-hashes --no-build-isolation --requirement requirements/dev.lock
	@touch $@

$(DOCS): $(READY) requirements/docs.lock
	@echo "Adding what the documentation needs, from requirements/docs.lock"
	@$(INSTALL) --require-hashes --no-build-isolation --requirement requirements/docs.lock
	@touch $@

bench-start: $(DEV) ## what a command takes to start, against `import numpy` (seconds)
	$(BIN)/python benchmarks/start.py

bench-plan: $(DEV) ## planned tests against random ones, on simulated campaigns (a minute)
	$(BIN)/python benchmarks/plan.py

bench-refits: $(DEV) ## resampled refits of every law against SciPy, one by one (5 min)
	$(BIN)/python benchmarks/refits.py 1000

bench-left-out: $(DEV) ## leaving curves out of 300, 1000 and 3000: time and its growth (12 min)
	$(BIN)/python benchmarks/left_out.py

MAX ?= 10000

bench-scale: $(DEV) ## 100 to MAX=10000 runs through the whole workflow: time, memory, bytes; renews its page (half an hour)
	$(BIN)/python benchmarks/scale.py $(MAX)

bench-ingest: $(DEV) ## 10 million rows: time and memory against pyarrow and pandas (minutes)
	$(BIN)/python benchmarks/ingest.py

bench-blind: $(DEV) ## ten laboratories of their own, 72 faults each: detection, reasons, intervals (3 min)
	$(BIN)/python benchmarks/blind.py

bench-coverage: $(DEV) ## 200 simulated campaigns per oil: do the intervals cover the truth (10 min)
	$(BIN)/python benchmarks/coverage.py

# The rivals' packages stay out of .venv: nothing but these benchmarks needs them.
RIVALS := .venv-rivals

.PHONY: rivals
rivals:
	@$(MAKE) --no-print-directory VENV=$(RIVALS) setup
	@$(if $(UV),'$(UV)' pip install --quiet --compile-bytecode --python $(RIVALS)/bin/python,\
		$(RIVALS)/bin/python -m pip install --quiet --disable-pip-version-check) \
		--require-hashes --requirement benchmarks/rivals.lock

bench-fit: rivals ## the fit against other optimisers, 20 seeds on each oil (half an hour)
	$(RIVALS)/bin/python benchmarks/fit.py

bench-ga: rivals ## a genetic algorithm, as the paper used one, beside our fit: renews its table (10 min)
	$(RIVALS)/bin/python benchmarks/genetic.py

# What searches the code, the workflows of GitHub and the locked packages for known weaknesses.
AUDIT := .venv-audit
AUDITED := $(AUDIT)/locked-$(PLACE)

$(AUDITED): tests/lint/audit.lock $(DEV)
	@rm -rf $(AUDIT) && $(if $(UV),'$(UV)' venv --quiet --python $(BIN)/python $(AUDIT),$(BIN)/python -m venv $(AUDIT))
	@$(if $(UV),'$(UV)' pip install --quiet --python $(AUDIT)/bin/python,\
		$(AUDIT)/bin/python -m pip install --quiet --disable-pip-version-check) \
		--require-hashes --requirement tests/lint/audit.lock
	@touch $@

.PHONY: audit
audit: $(AUDITED) ## known weaknesses: bandit, zizmor, licences; advisories, if there is a network (a minute)
	$(AUDIT)/bin/bandit --quiet --recursive --configfile pyproject.toml workflow
	$(AUDIT)/bin/zizmor --offline --quiet --persona=pedantic .github/workflows docs/nightly/github-self-hosted.yml
	$(BIN)/python tests/lint/licences.py
	$(BIN)/python tests/lint/advisories.py $(AUDIT)/bin/pip-audit

# What makes the faults stays out of .venv too.
MUTATION := .venv-mutation

bench-mutation: ## how many small faults in seven rooms the quick tests see (two hours)
	@$(MAKE) --no-print-directory VENV=$(MUTATION) dev
	@$(if $(UV),uv pip install --quiet --compile-bytecode --python $(MUTATION)/bin/python,\
		$(MUTATION)/bin/python -m pip install --quiet --disable-pip-version-check) \
		--require-hashes --requirement benchmarks/mutation.lock
	$(MUTATION)/bin/python benchmarks/mutation.py

# Extras stay in the lock: without them pip may take a newer version and then refuses it.
# Pins that still fit pyproject.toml stay; `make upgrade` moves them. One version of each package
# for every Python ("fewest"): what a fit yields must not depend on the interpreter's age.
# The client of object storage takes no newer python-dateutil. It is the same without the client: what
# a release was made with must not depend on where it is kept.
COMPILE = echo 'python-dateutil<3' | $(or $(UV),$(BIN)/uv) pip compile --quiet $(UPGRADE) --universal --fork-strategy fewest \
	--generate-hashes --no-strip-extras --no-emit-index-url --python-version 3.11 --custom-compile-command "make lock" \
	--constraint -

# All but slurm, which would slow down every start of Snakemake in the tests.
EXTRAS = report workflow clone dev

lock: ## renew the lock files after a change of pyproject.toml
	@$(if $(UV),:,test -x $(BIN)/uv || $(MAKE) dev)
	$(COMPILE) --extra workflow --extra clone pyproject.toml --output-file requirements/run.lock
	$(COMPILE) --extra s3 --constraint requirements/run.lock pyproject.toml \
		--output-file requirements/s3.lock
	$(COMPILE) $(EXTRAS:%=--extra %) --constraint requirements/run.lock pyproject.toml \
		--output-file requirements/dev.lock
	$(COMPILE) --extra docs --constraint requirements/dev.lock pyproject.toml \
		--output-file requirements/docs.lock
	$(COMPILE) --extra slurm --constraint requirements/run.lock pyproject.toml \
		--output-file requirements/slurm.lock
	$(COMPILE) --constraint requirements/run.lock benchmarks/rivals.in \
		--output-file benchmarks/rivals.lock
	$(COMPILE) tests/lint/audit.in --output-file tests/lint/audit.lock
	$(COMPILE) --constraint requirements/run.lock --constraint requirements/dev.lock benchmarks/mutation.in \
		--output-file benchmarks/mutation.lock

schemas: $(DEV) ## renew schemas and reference pages; with RESULTS="results/demo ..." the examples of tables too
	$(BIN)/python docs/_ext/generate.py $(RESULTS)

notebooks: $(READY) ## run docs/notebooks and store their text and pictures anew
	$(BIN)/python tests/helpers/notebooks.py

licences: $(DEV) ## renew docs/licences.csv after a change of requirements/run.lock
	$(BIN)/python tests/lint/licences.py --write

upgrade: ## the same, with the newest release of everything
	@$(MAKE) lock UPGRADE=--upgrade

clean: ## remove .venv and caches; data/, results/ and .snakemake/ stay
	rm -rf $(VENV) .venv-* .import_linter_cache .mypy_cache .pytest_cache .ruff_cache .hypothesis htmlcov .coverage .coverage.*
	find workflow tests -type d -name __pycache__ -prune -exec rm -rf {} +

help: ## this list
	@awk 'BEGIN {FS = ":.*## "} /^[a-z-]+:.*## / {printf "make %-10s %s\n", $$1, $$2}' Makefile
