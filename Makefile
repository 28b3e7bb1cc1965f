# Commands for developers and CI; `make help` lists them. They need git, make and Python 3.11 or newer,
# and install into .venv with the versions of constraints.txt. `make test` needs nothing else. With
# Node.js, `make test-all` includes the glTF validator, and with Chromium the web pages.

SHELL := /bin/sh
.DELETE_ON_ERROR:
.DEFAULT_GOAL := help

PYTHON ?= python3.11 python3

python := .venv/bin/python
pins := pyproject.toml constraints.txt

# pip builds in an isolated environment, which only these variables pin: the first up to pip 25.2, the
# second later. The paths are relative, because pip splits the values at spaces.
export PIP_CONSTRAINT := constraints.txt
export PIP_BUILD_CONSTRAINT := constraints.txt
export PIP_DISABLE_PIP_VERSION_CHECK := 1

# Processes that run side by side use all cores. Threads of linear algebra would spin beside them.
test test-all test-long: export OPENBLAS_NUM_THREADS := 1

# Without bytecode each start takes 2 s longer, because Python compiles 1,400 modules.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: help
help: ## list the targets
	@sed -n 's/^\([a-z-]*\):.*## \(.*\)/\1|\2/p' $(MAKEFILE_LIST) | awk -F'|' '{printf "make %-18s %s\n", $$1, $$2}'

# --- installation: stamps are renewed when pyproject.toml or the pins change ----------------------

# pip 26 installs in two thirds of the time of that of Python 3.11.
.venv/bin/pip:
	@for python in $(PYTHON); do \
	  if "$$python" -c 'import ensurepip, sys, venv; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then \
	    echo "Creating .venv with $$("$$python" --version)"; \
	    "$$python" -m venv .venv && exec $(python) -m pip install -q --upgrade 'pip>=26'; \
	  fi; \
	done; \
	echo "No Python 3.11 or newer with its venv module among: $(PYTHON)." >&2; \
	echo "Install one (Debian and Ubuntu: apt-get install python3 python3-venv), or name it: make PYTHON=/path/to/python3.11 ..." >&2; \
	exit 1

.venv/.installed: .venv/bin/pip $(pins)
	# Python compiles a module on its first import: 8 s less for what is never imported
	$(python) -m pip install -q --no-compile -c constraints.txt -e '.[service]'
	@touch $@

# In one go: pip resolves once.
.venv/.installed-test: .venv/bin/pip $(pins)
	$(python) -m pip install -q --no-compile -c constraints.txt -e '.[service,test]'
	@touch .venv/.installed $@

.venv/.installed-test-all: .venv/.installed-test
	$(python) -m pip install -q -c constraints.txt -e '.[service,test,test-all]'
	@touch $@

.venv/.installed-lint: .venv/.installed-test-all
	$(python) -m pip install -q -c constraints.txt -e '.[service,test,test-all,lint]'
	@touch $@

# All that the checks need.
.venv/.installed-all: .venv/bin/pip $(pins)
	$(python) -m pip install -q --no-compile -c constraints.txt -e '.[service,test,test-all,lint,docs]'
	@touch .venv/.installed .venv/.installed-test .venv/.installed-test-all .venv/.installed-lint .venv/.installed-docs $@

.venv/.installed-figures: .venv/.installed
	$(python) -m pip install -q -c constraints.txt -e '.[service,peers,plot]'
	@touch $@

.venv/.installed-docs: .venv/.installed
	$(python) -m pip install -q -c constraints.txt -e '.[service,docs]'
	@touch $@

node_packages := $(patsubst %,%/node_modules/.package-lock.json,tests/azurite tests/clients tests/gltf web)

$(node_packages): %/node_modules/.package-lock.json: %/package.json %/package-lock.json
	@if command -v npm >/dev/null; then \
	  npm ci --prefix $* --no-audit --no-fund --loglevel=error && touch $@; \
	else \
	  echo "npm is not installed: tests that need $* will be skipped."; \
	fi

.PHONY: install
install: .venv/.installed ## install into .venv and compile the kernels that have changed
	$(python) -m gamutcore.warm

.PHONY: install-all
install-all: .venv/.installed-all $(node_packages) ## install what all checks need, and compile the kernels
	$(python) -m gamutcore.warm

# --- use ------------------------------------------------------------------------------------------

.PHONY: serve
serve: .venv/.installed ## serve on http://127.0.0.1:8000, data under var/ (docs/operations.md)
	exec .venv/bin/gamut serve

# The three groups of tests are declared in tests/conftest.py.
pytest := $(python) -m pytest --dist loadfile --no-loadscope-reorder

# T names files, folders or tests, and K is an expression of pytest. Only these tests run, in one
# process, and each compiles the kernels that it needs.
ifneq ($(T)$(K),)
test: .venv/.installed-test
	$(python) -m pytest $(T) $(if $(K),-k '$(K)')
else
test: .venv/.installed-test
	$(python) -m gamutcore.warm default optional
	$(pytest) -n auto -m 'not slow and not long'
endif

.PHONY: test
test: ## run the tests that need no other program, or some: make test T=tests/gamutcore/test_mesh.py, make test K=volume

# Two processes per core: many tests wait for servers, browsers and brokers. After `make test`, the rest
# is GROUP='slow and not long'.
GROUP := not long

.PHONY: test-all
test-all: .venv/.installed-test-all $(node_packages) ## also the tests with servers, Redis, S3, a browser, Node.js, plain Python
	$(python) -m gamutcore.warm
	$(pytest) -n $$((2 * $$(getconf _NPROCESSORS_ONLN))) -m '$(GROUP)'

.PHONY: test-long
test-long: .venv/.installed-test-all $(node_packages) ## faults, fuzzing, more emulators, accuracy, chart, generated clients, random examples
	$(python) -m gamutcore.warm
	$(pytest) -n auto -m 'long or hypothesis' --hypothesis-profile=long

.PHONY: fuzz
fuzz: install ## feed mutated files to the parsers for FUZZ_SECONDS (600)
	$(python) tests/fuzz/fuzz.py --seconds $(or $(FUZZ_SECONDS),600)

.PHONY: bench
bench: install .venv/.installed-test-all ## measure builds, levels and the service; updates docs/benchmarks.md
	$(python) -m benchmarks.bench

.PHONY: bench-boundaries
bench-boundaries: install .venv/.installed-test-all ## compare the volumes of boundaries with independent ones; writes docs/benchmarks.md
	$(python) -m benchmarks.bench --only boundaries

.PHONY: bench-startup
bench-startup: .venv/.installed-test-all ## measure a fresh clone up to its first gamut; writes docs/benchmarks.md
	$(python) -m benchmarks.bench --only startup

.PHONY: same
same: install .venv/.installed-test-all ## compare what users see with an earlier revision (BEFORE=...)
	$(python) -m benchmarks.same $(or $(BEFORE),HEAD)

.PHONY: bench-queries
bench-queries: install .venv/.installed-test-all .venv/.installed-figures ## measure queries beside trimesh and Manifold; writes docs/benchmarks.md
	$(python) -m benchmarks.bench --only queries level-queries

.PHONY: bench-recipes
bench-recipes: install .venv/.installed-test-all ## measure recipes beside Argyll's xicclu; writes docs/benchmarks.md
	$(python) -m benchmarks.bench --only recipes recipes-continuity

.PHONY: bench-profiles
bench-profiles: install .venv/.installed-test-all ## measure profiles beside Argyll's colprof, 20 minutes; writes docs/benchmarks.md
	$(python) -m benchmarks.bench --only profiles

.PHONY: bench-links
bench-links: install .venv/.installed-test ## measure links and clipping beside collink and transicc, 15 minutes; writes docs/benchmarks.md
	$(python) -m benchmarks.bench --only links clips

.PHONY: bench-viewer
bench-viewer: install .venv/.installed-test-all web/node_modules/.package-lock.json ## measure the viewer in Chromium; writes docs/benchmarks.md
	$(python) -m benchmarks.bench --only viewer

.PHONY: soak
soak: install .venv/.installed-test-all ## load the service for minutes; updates docs/reliability.md
	$(python) -m benchmarks.reliability --only soak

.PHONY: faults
faults: install .venv/.installed-test-all $(node_packages) ## inject faults for an hour; updates docs/reliability.md
	$(python) -m benchmarks.reliability --only faults hostile

.PHONY: figures
figures: install .venv/.installed-figures ## measure accuracy beside other libraries; updates docs/decimation.md
	$(python) -m benchmarks.figures

.PHONY: documents
documents: install ## update the generated tables of all documents
	$(python) -m benchmarks.documents

version := $(shell sed -n 's/^__version__ = "\(.*\)"/\1/p' gamutcore/version.py)

.PHONY: docs
docs: install .venv/.installed-docs web/node_modules/.package-lock.json ## build the site of the documents into build/docs/VERSION; warnings are errors
	rm -rf build/docs/$(version) docs/api
	PYTHONPATH=$(CURDIR)/client $(python) -m sphinx -q -W --keep-going -b html -c docs/site . build/docs/$(version)
	@sed 's|url=docs|url=$(version)/docs|; s|href="docs|href="$(version)/docs|' docs/site/extra/index.html > build/docs/index.html
	@if chromium=$$(command -v chromium); then CHROMIUM=$$chromium node docs/site/check.mjs build/docs/$(version); \
	else echo "The pages are not checked in a browser: chromium is not installed."; fi

# --- checks ---------------------------------------------------------------------------------------

.PHONY: lint
lint: .venv/.installed-lint ## ruff (rules and formatting) and shellcheck
	$(python) -m ruff check .
	$(python) -m ruff format --check .
	.venv/bin/shellcheck .ci/run .ci/wheel-check

.PHONY: format
format: .venv/.installed-lint ## format with ruff, and fix what ruff can fix
	$(python) -m ruff check --fix .
	$(python) -m ruff format .

.PHONY: types
types: .venv/.installed-lint ## mypy, strict, on both packages and the benchmarks
	$(python) -m mypy

.PHONY: contracts
contracts: .venv/.installed-lint ## import-linter: no web in gamutcore, data flows one way
	PYTHONPATH=client .venv/bin/lint-imports

.PHONY: openapi
openapi: .venv/.installed ## regenerate openapi/openapi.json
	.venv/bin/gamut openapi > openapi/openapi.json.new
	mv openapi/openapi.json.new openapi/openapi.json

.PHONY: openapi-check
openapi-check: .venv/.installed ## compare openapi/openapi.json with the document of the app
	.venv/bin/gamut openapi | diff -u openapi/openapi.json -

.PHONY: architecture
architecture: .venv/.installed ## redraw docs/pictures/architecture.svg from the imports
	$(python) docs/pictures/architecture.py

.PHONY: viewer
viewer: web/node_modules/.package-lock.json ## check the types of web/ and build the viewer into gamutcore/export/viewer
	npm --prefix web run check
	npm --prefix web run build

.PHONY: npm
npm: web/node_modules/.package-lock.json ## pack the npm package of web/boundary into dist/
	mkdir -p dist
	cd web/boundary && npm pack --pack-destination ../../dist

.PHONY: examples
examples: install ## make the built-in examples of the viewer, gamutcore/export/examples
	PYTHONPATH=$(CURDIR) $(python) docs/pictures/examples.py

.PHONY: viewer-check
viewer-check: web/node_modules/.package-lock.json ## compare gamutcore/export/viewer with what web/ gives
	npm --prefix web run check
	npm --prefix web run build -- --check

.PHONY: hues
hues: install .venv/.installed-docs ## redraw docs/pictures/hues.png, and print the table of its record
	$(python) docs/pictures/hues.py

.PHONY: spatial
spatial: install .venv/.installed-docs ## redraw docs/pictures/spatial.png, and print the table of its record
	$(python) docs/pictures/spatial.py

.PHONY: links
links: install .venv/.installed-docs ## redraw docs/pictures/links.png and neutral-axis.png, and print the table of docs/links.md
	$(python) docs/pictures/links.py

.PHONY: chromaticity
chromaticity: install .venv/.installed-docs ## redraw docs/pictures/chromaticity.svg
	$(python) docs/pictures/chromaticity.py

.PHONY: intervals
intervals: install .venv/.installed-docs ## redraw docs/pictures/intervals.svg
	$(python) docs/pictures/intervals.py

.PHONY: concepts
concepts: install .venv/.installed-docs ## redraw the pictures of docs/concepts.md
	$(python) docs/pictures/concepts.py

.PHONY: viewer-pictures
viewer-pictures: install .venv/.installed-test-all web/node_modules/.package-lock.json ## take the crops of the viewer for README, docs/start.md and docs/tour.md
	PYTHONPATH=$(CURDIR) $(python) docs/pictures/viewer.py

.PHONY: packages
packages: ## list what the image installs, with versions, in build/packages.txt (SECURITY.md scans it)
	@mkdir -p build
	sed -n 's/^\([a-z0-9._-]*\)==\([^ ;]*\).*/\1 \2/p' docker/requirements.txt > build/packages.txt
	@echo "$$(wc -l < build/packages.txt) packages in build/packages.txt"

.PHONY: image-lint
image-lint: .venv/.installed-lint ## hadolint on the Dockerfile
	.venv/bin/hadolint --failure-threshold style Dockerfile

.PHONY: hooks
hooks: .venv/.installed-lint ## have git run the checks of .pre-commit-config.yaml
	.venv/bin/pre-commit install

.PHONY: static-checks
static-checks: lint types contracts openapi-check viewer-check image-lint packages ## all checks that run no test

.PHONY: check
check: static-checks test-all ## all checks, and all tests but the long ones

# --- distribution ---------------------------------------------------------------------------------

# Pythons that get a wheel with machine code: those of the machine.
WHEEL_PYTHONS ?= $(shell for python in python3.11 python3.12 python3.13 python3.14; do $$python -c 'import sys; print(sys.executable)' 2>/dev/null; done)

.PHONY: wheels
wheels: .venv/bin/pip ## build the wheels of a release into dist/: pure, of the client, and compiled for each of WHEEL_PYTHONS
	$(python) .ci/wheels.py dist $(WHEEL_PYTHONS)

.PHONY: wheel-check
wheel-check: .venv/bin/pip ## build the pure wheel and that of the client, install each without extras and use it
	rm -rf build/checked-wheels
	$(python) -m pip wheel -q --no-deps --wheel-dir build/checked-wheels . ./client
	.ci/wheel-check build/checked-wheels/gamut_boundary_service-*.whl build/checked-wheels/gamutclient-*.whl

.PHONY: image-check
image-check: .venv/.installed ## build the container image and use it (Debian, as root; .ci/run installs the tools)
	$(python) docker/image.py

.PHONY: constraints
constraints: ## pin the newest versions that pyproject.toml allows (Python 3.11)
	rm -rf build/constraints
	python3.11 -m venv build/constraints
	env -u PIP_CONSTRAINT -u PIP_BUILD_CONSTRAINT build/constraints/bin/python -m pip install -q -e '.[service,celery,cloud,test,test-all,lint,peers,plot,docs]' hatchling editables
	{ sed -n '/^#/p' constraints.txt; \
	  build/constraints/bin/python -m pip freeze --exclude-editable --exclude pip --exclude setuptools; } > build/constraints.txt
	mv build/constraints.txt constraints.txt
	build/constraints/bin/python docker/lock.py
	rm -rf build/constraints

.PHONY: clean
clean: ## remove installed, built and cached files; keep the data under var/
	rm -rf .venv build dist docs/api tests/*/node_modules web/node_modules web/boundary/dist web/boundary/LICENSE .pytest_cache .hypothesis .mypy_cache .ruff_cache .import_linter_cache
	find gamutcore service tests benchmarks -name __pycache__ -type d -prune -exec rm -rf {} +
