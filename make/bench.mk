# The benchmarks: one file each in benchmarks/, with arguments of its own.

# Packages of rivals, and what puts faults into code, stay out of .venv: nothing else needs them.
RIVALS := .venv-rivals
MUTATION := .venv-mutation
VENV_fit := $(RIVALS)
VENV_genetic := $(RIVALS)
VENV_mutation := $(MUTATION)
NEEDED_fit := rivals
NEEDED_genetic := rivals
NEEDED_mutation := mutation

# Some systems have a variable NAME of their own in the environment: it names no benchmark.
BENCHMARK := $(if $(filter command,$(origin NAME)),$(NAME))

.PHONY: bench rivals mutation
bench: $(or $(NEEDED_$(BENCHMARK)),$(DEV)) ## one benchmark: make bench NAME=fit ARGS=5; without NAME their list
	$(if $(wildcard benchmarks/$(or $(BENCHMARK),__main__).py),,$(error There is no benchmark $(BENCHMARK): make bench lists them))
	@$(IN_VENV) $(or $(VENV_$(BENCHMARK)),$(VENV))/bin/python benchmarks$(if $(BENCHMARK),/$(BENCHMARK).py) $(ARGS)

rivals:
	@$(MAKE) --no-print-directory VENV=$(RIVALS) setup
	@$(call INSTALL_INTO,$(RIVALS)) --require-hashes --requirement benchmarks/rivals.lock

mutation:
	@$(MAKE) --no-print-directory VENV=$(MUTATION) dev
	@$(call INSTALL_INTO,$(MUTATION)) --require-hashes --requirement benchmarks/mutation.lock
