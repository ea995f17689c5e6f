# From a bare machine (python3 >= 3.11 and make) to results: `make demo`; to a checked tree: `make test`.

.DEFAULT_GOAL := help
SHELL := /bin/bash
VENV := .venv
BIN := $(VENV)/bin
RESULTS := results
OLDEST_EXTRAS := fast plot film nastran ansys mujoco xarray
OLDEST_TESTS := tests/test_front_door.py tests/test_units.py tests/mesh tests/storage tests/reduction tests/viz/test_films.py
WORKERS ?= 2
# Each worker takes half of the files in their order, then of what is left: neighbours share programs and fixtures.
SHARED := -n $(WORKERS) --dist worksteal
# The first interpreter that is new enough; `make PYTHON=/path/to/python3 ...` overrides it.
PYTHON ?= $(shell for p in python3 python3.13 python3.12 python3.11; do \
  "$$p" -c 'import sys; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1 && { echo "$$p"; break; }; done)
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check
# uv takes seconds where pip takes minutes, for it links what its cache has; where it cannot install, pip does.
INSTALL = $(PIP) uv && $(BIN)/uv pip install --quiet --python $(BIN)/python -e '.[$(EXTRAS)]' || $(PIP) -e '.[$(EXTRAS)]'
INSTALL_FAILED := echo "Installing failed, see above. Remedy: check the network and run make again"; exit 2
# One thread per process: the test workers share the cores between them. Bytecode is kept for those they start.
ONE_THREAD := PYTHONDONTWRITEBYTECODE= OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 MKL_NUM_THREADS=1

.PHONY: help demo test test-all soak docs site package oldest lint format clean

help:
	@echo "make demo      set up, then run the rotating beam and the 61.5 m blade; results in $(RESULTS)/"
	@echo "make test      set up, then check style, types, layers and run the tests: three minutes on two cores, five after changes of what is compiled"
	@echo "make test-all  the same with the slow tests: an hour; before every release"
	@echo "make soak      kill runs and damage files by the hundred, the longest quick benchmarks: an hour"
	@echo "make docs      run the examples and build the site of the documentation in build/html (make site: without running them)"
	@echo "make package   build wheel and sdist, install each in an empty environment and run an example there"
	@echo "make oldest    install the oldest versions that pyproject.toml allows, and run a part of the tests with them"
	@echo "make lint      style, types and layers only"
	@echo "make format    rewrite the sources in the project's style"
	@echo "make clean     remove the environment and the results"

demo: $(VENV)/.ready
	@$(BIN)/supple benchmark rotating-beam --quick -o $(RESULTS)/rotating-beam
	@$(BIN)/supple run examples/blade.toml -o $(RESULTS)/blade --force
	@echo
	@echo "Done. Tables, pictures, animations and HDF5 files are in $(CURDIR)/$(RESULTS)/:"
	@find $(RESULTS)/rotating-beam $(RESULTS)/blade -type f | sort | sed 's/^/  /'

test: lint
	$(ONE_THREAD) $(BIN)/python -m pytest $(SHARED)

test-all: lint
	$(ONE_THREAD) $(BIN)/python -m pytest $(SHARED) -m 'not soak'

soak: $(VENV)/.ready-dev
	$(ONE_THREAD) $(BIN)/python -m pytest $(SHARED) -m soak
	$(BIN)/python tools/fuzz -n 100000

docs: $(VENV)/.ready-dev
	$(ONE_THREAD) $(BIN)/python tools/site/gallery.py build/gallery
	@$(MAKE) site

site: $(VENV)/.ready-dev
	$(BIN)/python tools/site/assemble.py build/site build/gallery
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --quiet --strict

# From a folder of its own, so that what is installed runs and not what stands here.
package: $(VENV)/.ready-dev
	@$(PIP) build ziglang
	$(BIN)/python tools/release/prebuilt_fmus.py
	@rm -rf dist build/tried && $(BIN)/python -m build --outdir dist . >/dev/null
	@for file in dist/*; do echo "Trying $$file"; tried=build/tried/$$(basename $$file); \
	  "$(PYTHON)" -m venv $$tried && $$tried/bin/python -m pip install --quiet --disable-pip-version-check "$$file[plot]" && \
	  ( cd $$tried && bin/supple run $(CURDIR)/examples/pendulum.toml -o pendulum >/dev/null && bin/supple --version ) || exit 1; done
	@ls -l dist

# The lower bounds of pyproject.toml, with the newest versions of what these depend on.
oldest: $(VENV)/bin/python
	@$(PIP) uv
	@rm -rf build/oldest && "$(PYTHON)" -m venv build/oldest
	$(BIN)/uv pip compile --quiet --resolution lowest-direct $(OLDEST_EXTRAS:%=--extra %) pyproject.toml -o build/oldest.txt
	$(BIN)/uv pip install --quiet --python build/oldest/bin/python -r build/oldest.txt pytest
	$(BIN)/uv pip install --quiet --python build/oldest/bin/python --no-deps .
	$(ONE_THREAD) build/oldest/bin/python -m pytest -p no:warnings $(OLDEST_TESTS)

lint: $(VENV)/.ready-dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/ty check
	$(BIN)/lint-imports

format: $(VENV)/.ready-dev
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

clean:
	rm -rf $(VENV) $(RESULTS) build dist

$(VENV)/bin/python:
	@test -n "$(PYTHON)" || { echo "supple needs Python 3.11 or newer; found: $$(python3 --version 2>&1 || true)"; \
	  echo "Remedy: install one (Debian, Ubuntu: apt install python3 python3-venv), or run: make PYTHON=/path/to/python3.11"; exit 2; }
	@"$(PYTHON)" -c 'import ensurepip, venv' 2>/dev/null || { \
	  echo "$(PYTHON) ($$("$(PYTHON)" --version)) cannot create virtual environments: its venv or ensurepip module is missing."; \
	  echo "Remedy (Debian, Ubuntu): apt install python3-venv"; exit 2; }
	@echo "Creating the environment $(VENV) with $$("$(PYTHON)" --version)"
	@"$(PYTHON)" -m venv $(VENV)

# Stamps, renewed when the dependencies change: the demo needs no developer tools.
$(VENV)/.ready: EXTRAS := fast,plot
$(VENV)/.ready: pyproject.toml | $(VENV)/bin/python
	@echo "Installing supple and its dependencies into $(VENV) (once; about 800 MB, a minute or two)"
	@$(INSTALL) || { $(INSTALL_FAILED); }
	@touch $@

$(VENV)/.ready-dev: EXTRAS := fast,plot,dev
$(VENV)/.ready-dev: pyproject.toml | $(VENV)/bin/python
	@echo "Installing supple and the developer tools into $(VENV) (once; about 1.4 GB)"
	@$(INSTALL) || { $(INSTALL_FAILED); }
	@touch $(VENV)/.ready $@
