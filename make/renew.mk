# What is kept in the repository and made from something else: lock files, licences, schemas, pages.

.PHONY: lock upgrade licences schemas notebooks

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

upgrade: ## the same, with the newest release of everything
	@$(MAKE) lock UPGRADE=--upgrade

licences: $(DEV) ## renew docs/licences.csv after a change of requirements/run.lock
	$(BIN)/python tests/lint/licences.py --write

schemas: $(DEV) ## renew schemas and reference pages; with RESULTS="results/demo ..." the examples of tables too
	$(BIN)/python docs/_ext/generate.py $(RESULTS)

notebooks: $(READY) ## run docs/notebooks and store their text and pictures anew
	$(BIN)/python tests/helpers/notebooks.py
