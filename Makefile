# `make` lists the targets. PYTHON selects the interpreter that makes the environment (3.11 to 3.13).
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --quiet --disable-pip-version-check
CHECKED := src tests benchmarks examples tools docs/conf.py
# A file of tests runs in one process, so that what its tests share is made once.
PYTEST := $(BIN)/pytest --numprocesses=auto --maxprocesses=4 --dist=loadfile

.DEFAULT_GOAL := help
.PHONY: help demo quick test pytest verification lint docs reference format rooms benchmark benchmark-control benchmark-studies campaign benchmark-peers dolfinx clean

help: ## list the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "  make %-16s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

demo: $(VENV)/installed demo/m2.toml ## install into .venv, run the stop maneuver of the antenna M2, write figures and a page to demo/m2
	@$(BIN)/tautflex check demo/m2.toml
	@$(BIN)/tautflex run demo/m2.toml -o demo/m2 --force
	@$(BIN)/tautflex report demo/m2 --force
	@echo "Open $(CURDIR)/demo/m2/report.html in a browser: the antenna turns, stops and rings."

quick: $(VENV)/tools ## run the tests that neither compile with JAX nor take long: a minute, after every change
	$(PYTEST) -m 'not (slow or jax or campaign)'

test: lint pytest ## install the test tools; check format, lint, types, import contract; run all tests

pytest: $(VENV)/tools
	$(PYTEST)

verification: $(VENV)/tools ## run all tests and rewrite docs/verification.md from what they measured
	$(PYTEST) --verification-table=docs/verification.md

lint: $(VENV)/tools ## check format, lint rules, types and the import contract
	$(BIN)/ruff format --check $(CHECKED)
	$(BIN)/ruff check $(CHECKED)
	$(BIN)/mypy
	$(BIN)/lint-imports

docs: $(VENV)/docs ## run all examples and tutorials, build the manual, docs/_build/html/index.html (minutes; warnings are errors)
	$(BIN)/sphinx-build --quiet --fail-on-warning --builder html docs docs/_build/html
	@echo "Open $(CURDIR)/docs/_build/html/index.html in a browser."

reference: $(VENV)/installed ## write docs/case.md, the keys of the case file, from the classes
	$(BIN)/tautflex keys --markdown > docs/case.md

format: $(VENV)/tools ## rewrite the sources in the house format
	$(BIN)/ruff format $(CHECKED)
	$(BIN)/ruff check --fix $(CHECKED)

rooms: $(BIN)/python ## draw the rooms and their imports, docs/figures/rooms.svg
	$(BIN)/python tools/house.py

benchmark: $(VENV)/installed ## measure step cost, its growth with the mesh, direct solvers, set-up and start-up (minutes)
	$(BIN)/python benchmarks/step_cost.py
	$(BIN)/python benchmarks/step_cost.py --growth
	$(BIN)/python benchmarks/step_cost.py --stretches
	$(BIN)/python benchmarks/linear_solvers.py
	$(BIN)/python benchmarks/setup_cost.py
	$(BIN)/python benchmarks/start_up.py

benchmark-control: $(VENV)/tools ## control steps per second of plants, environments and the functional twin (minutes)
	$(BIN)/python benchmarks/control_steps.py

benchmark-studies: $(VENV)/tools ## cost per point of sweeps: engine, processes, batches (minutes)
	$(BIN)/python benchmarks/studies.py

campaign: $(VENV)/tools ## the stop under control, then policies beside tuned laws, into docs (hours; goes on where it was interrupted)
	$(BIN)/python benchmarks/stop_control.py
	$(BIN)/python benchmarks/learning_campaign.py --write

benchmark-peers: $(VENV)/installed ## install Kratos, Exudyn and scikit-fem into .peers, run beside them and DOLFINx, write docs/benchmarks.md (an hour)
	$(BIN)/python benchmarks/peers/install.py
	$(BIN)/python benchmarks/peers/run.py

dolfinx: ## install the peer DOLFINx system-wide (Debian package python3-dolfinx; needs root; nothing else asks for it)
	apt-get install --yes --no-install-recommends python3-dolfinx

clean: ## remove the environment, caches and demo results
	rm -rf $(VENV) .peers demo docs/_build docs/generated build dist .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache
	find src tests benchmarks -name __pycache__ -type d -prune -exec rm -rf {} +

# An existing case is never rewritten: it may carry the reader's own changes.
demo/m2.toml: | $(VENV)/installed
	@mkdir -p demo
	@$(BIN)/tautflex init demo/m2.toml

$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(not (3, 11) <= sys.version_info < (3, 14))' || \
	  { echo "tautflex needs Python 3.11 to 3.13; choose one with: make PYTHON=python3.12 $(MAKECMDGOALS)" >&2; exit 1; }
	@$(PYTHON) -m venv $(VENV)

$(VENV)/installed: pyproject.toml constraints.txt | $(BIN)/python
	@echo "Installing tautflex into $(VENV) (a minute or two, once) ..."
	@$(PIP) install --constraint constraints.txt --editable .
	@touch $@

$(VENV)/tools: $(VENV)/installed
	@echo "Installing the test tools into $(VENV) ..."
	@$(PIP) install --constraint constraints.txt --editable '.[dev]'
	@touch $@

$(VENV)/docs: $(VENV)/installed
	@echo "Installing what builds the manual into $(VENV) ..."
	@$(PIP) install --constraint constraints.txt --editable '.[docs]'
	@touch $@
