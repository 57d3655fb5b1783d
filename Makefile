# make, make install    the virtual environment .venv with graincal in it: .venv/bin/graincal
# make demo    a whole calibration on an embedded default, with its report
# make test    the test suite, a process for each of up to eight cores; PYTEST_ARGS goes to pytest, such as PYTEST_ARGS='-n 0 tests/dem' for one process and a part of it
# make test-cluster    the faults of a cluster, through a real Slurm of one node: a quarter of an hour; needs root, and the packages slurm-wlm and munge
# make docs    the documentation as a site, in build/site; a warning or a broken link is an error
# make lint    what ruff, clang-format and mypy say of the code, in a virtual environment of their own, .venv-lint: half a minute at first, seconds later
# make format    the formatters, ruff's and clang-format, on the whole code
# All create the virtual environment .venv and build what they need first.
PYTHON ?= python3
VENV := .venv
INSTALLED := $(VENV)/.installed
TEST_INSTALLED := $(VENV)/.installed-test
DOCS_INSTALLED := $(VENV)/.installed-docs
SOURCES := pyproject.toml CMakeLists.txt $(shell find native -type f)

.PHONY: install demo docs test test-cluster lint format clean
install: $(INSTALLED)
	@echo "graincal is installed: .venv/bin/graincal, or graincal after: source .venv/bin/activate"

demo: $(INSTALLED)
	$(VENV)/bin/graincal demo

test: $(TEST_INSTALLED)
	$(VENV)/bin/python -m pytest --numprocesses auto --maxprocesses 8 --dist worksteal $(PYTEST_ARGS)

test-cluster: $(TEST_INSTALLED)
	$(VENV)/bin/python -m pytest --numprocesses 0 -m cluster -s tests/cluster $(PYTEST_ARGS)

docs: $(DOCS_INSTALLED)
	$(VENV)/bin/python -m sphinx -W --keep-going --quiet --builder html --doctree-dir build/doctrees docs build/site
	@echo "build/site/index.html"

LINT := .venv-lint
PYTHON_SOURCES := src tests benchmarks examples tools
NATIVE_SOURCES := $(shell find native -name '*.hpp' -o -name '*.cpp' -o -name '*.cu')

lint: $(LINT)/.installed
	$(LINT)/bin/ruff check --no-cache $(PYTHON_SOURCES)
	$(LINT)/bin/ruff format --check --quiet $(PYTHON_SOURCES)
	$(LINT)/bin/clang-format --dry-run --Werror $(NATIVE_SOURCES)
	$(LINT)/bin/mypy src/graincal

format: $(LINT)/.installed
	$(LINT)/bin/ruff format $(PYTHON_SOURCES)
	$(LINT)/bin/clang-format -i $(NATIVE_SOURCES)

$(LINT)/.installed: pyproject.toml
	test -x $(LINT)/bin/pip || $(PYTHON) -m venv $(LINT)
	$(LINT)/bin/pip install --quiet --disable-pip-version-check "ruff==0.17.6" "mypy==2.4.1" "clang-format==23.1.5" numpy pydantic
	touch $@

$(INSTALLED): $(SOURCES)
	@sh tools/check-machine.sh $(PYTHON)
	test -x $(VENV)/bin/pip || $(PYTHON) -m venv $(VENV)
	@echo "building the engine and fetching what it needs, about a minute ..."
	$(VENV)/bin/pip install --quiet --disable-pip-version-check --editable .
	touch $@

$(TEST_INSTALLED): $(SOURCES)
	@sh tools/check-machine.sh $(PYTHON)
	test -x $(VENV)/bin/pip || $(PYTHON) -m venv $(VENV)
	@echo "building the engine and fetching what it needs, about a minute ..."
	$(VENV)/bin/pip install --quiet --disable-pip-version-check --editable ".[test]"
	touch $(INSTALLED) $@

$(DOCS_INSTALLED): $(SOURCES)
	@sh tools/check-machine.sh $(PYTHON)
	test -x $(VENV)/bin/pip || $(PYTHON) -m venv $(VENV)
	$(VENV)/bin/pip install --quiet --disable-pip-version-check --editable ".[docs]"
	touch $(INSTALLED) $@

clean:
	rm -rf $(VENV) $(LINT) build
