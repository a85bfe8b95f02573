# The virtual environment, .venv: one stamp for the packages that running needs, one for oilfilm
# itself, and one each for the packages of the tests and of the documentation. A change of
# pyproject.toml alone installs nothing twice. Each stamp is touched last, so that a half-made .venv
# never counts as done.

VENV := .venv
BIN := $(VENV)/bin

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

# Choose another one with `make PYTHON=...`. 3.14 comes late because one package behind Snakemake
# has no wheel for it and needs a C compiler; nothing newer has wheels of NumPy in the lock.
PYTHON ?=
PYTHONS = $(or $(PYTHON),python3.13 python3.12 python3.11 python3.14 python3)

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
INSTALL_INTO = $(if $(UV),'$(UV)' pip install --quiet --compile-bytecode --python $(1)/bin/python,\
	PIP_USE_PEP517=1 $(1)/bin/python -m pip install --quiet --disable-pip-version-check)
INSTALL = $(call INSTALL_INTO,$(VENV))

# What Snakemake starts must find the same environment first.
# The shell's own PWD, because make would let the shell run what a folder's name may hold.
IN_VENV = PATH="$$PWD/$(BIN):$$PATH"
# Packages of another installation must not shadow the locked ones.
unexport PYTHONPATH PYTHONHOME
# Without bytecode each of many Pythons that are started would compile the library anew.
unexport PYTHONDONTWRITEBYTECODE

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
