# Checks that are not part of every `make test`.

# Counting lines doubles the time of the tests.
.PHONY: coverage
coverage: $(DEV) ## the tests again, with the share of the library's lines that they run (half an hour)
	$(PYTEST) --cov

.PHONY: docs-links
docs-links: $(DOCS) ## whether the addresses that the documentation names still answer
	$(IN_VENV) $(BIN)/sphinx-build $(SPHINX) --builder linkcheck docs docs/_build/links

.PHONY: findings
findings: $(DEV) ## run demo, thermal and etm-slim; are the numbers of README, findings and bearing those of the runs?
	for campaign in demo thermal etm-slim; do $(IN_VENV) $(BIN)/snakemake --config campaign=$$campaign || exit 1; done
	$(IN_VENV) $(BIN)/python tests/deng2026_study/findings.py

.PHONY: verify
verify: $(DEV) ## the demonstration twice, in other surroundings each: the same bytes (10 min)
	$(IN_VENV) $(BIN)/python tests/helpers/reproduce.py $(CAMPAIGN)

OTHER ?= python3.11

.PHONY: verify-python
verify-python: $(DEV) ## the demonstration on this Python and on OTHER=python3.11: the same bytes (10 min)
	@$(MAKE) --no-print-directory VENV=.venv-other PYTHON=$(OTHER) setup
	$(IN_VENV) $(BIN)/python tests/helpers/reproduce.py $(CAMPAIGN) "$$PWD/.venv-other/bin/python"

# What searches the code, the workflows of GitHub and the locked packages for known weaknesses.
AUDIT := .venv-audit
AUDITED := $(AUDIT)/locked-$(PLACE)

$(AUDITED): tests/lint/audit.lock $(DEV)
	@rm -rf $(AUDIT) && $(if $(UV),'$(UV)' venv --quiet --python $(BIN)/python $(AUDIT),$(BIN)/python -m venv $(AUDIT))
	@$(call INSTALL_INTO,$(AUDIT)) --require-hashes --requirement tests/lint/audit.lock
	@touch $@

.PHONY: audit
audit: $(AUDITED) ## known weaknesses: zizmor, licences; advisories, if there is a network (a minute)
	$(AUDIT)/bin/zizmor --offline --quiet --persona=pedantic .github/workflows docs/nightly/github-self-hosted.yml
	$(BIN)/python tests/lint/licences.py
	$(BIN)/python tests/lint/advisories.py $(AUDIT)/bin/pip-audit

# The packages beside oilfilm, with their tests. Whoever needs none of them may delete these, take
# them out of pyproject.toml and choose another default campaign.
BESIDE := workflow/deng2026_study workflow/simulated_lab tests/deng2026_study tests/simulated_lab
WITHOUT_BESIDE := /known-first-party/!s/"(workflow\/)?(deng2026_study|simulated_lab)",? ?//g; s/, \]/]/

.PHONY: apart
apart: ## make test in a copy of the last commit without the packages beside oilfilm (5 min)
	folder=$$(mktemp -d) && git clone --quiet . "$$folder" && cd "$$folder" && rm -r $(BESIDE) && \
	sed -E '$(WITHOUT_BESIDE)' pyproject.toml > new && mv new pyproject.toml && \
	sed 's/^campaign: demo/campaign: etm-slim/' config/config.yaml > new && mv new config/config.yaml && \
	$(MAKE) schemas && $(MAKE) test
