# `make help` lists the targets. Every target sets up what it needs and nothing twice.

# The Blender series of .venv: lts is 4.5 with Python 3.11, else 5.2 with Python 3.13; PYTHON=... names an interpreter.
BLENDER ?= lts
export PYTHON
# The series that test-matrix goes through.
SERIES ?= 4.2 4.5 5.0 5.2
# What `make render` renders.
BLEND ?= sample_blends/cups.blend
PICTURE ?= renders/cups.png
SIZE ?= 1280x720
SAMPLES ?= 8
# The pictures that `make gallery` makes; all of them when there is none.
PICTURES ?=
# How long test-monkey takes, and what it does.
MINUTES ?= 10
SEED ?= 1

VENV := .venv
BIN := $(VENV)/bin
SETUP := tools/setup_venv.sh $(VENV) $(BLENDER)

.DEFAULT_GOAL := help
.PHONY: help setup render test test-slow test-matrix test-ui test-monkey package lint format figures tables stability bench gallery docs clean

help:  ## this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-12s %s\n", $$1, $$2 }' Makefile

setup:  ## the environment for development, all layers
	@$(SETUP) test lint figures bench

render:  ## sample_blends/cups.blend -> renders/cups.png (BLEND=, PICTURE=, SIZE=, SAMPLES=)
	@$(SETUP)
	@mkdir -p $(dir $(PICTURE))
	@echo "Rendering $(BLEND), $(SIZE), $(SAMPLES) samples a pixel"
	@$(BIN)/dichromatic render $(BLEND) -o $(PICTURE) --size $(SIZE) --samples $(SAMPLES)

test: lint  ## lint, types, and the tests of the core and the add-on
	@$(SETUP) test figures
	$(BIN)/python -m pytest

test-slow:  ## the tests that take minutes
	@$(SETUP) test bench
	$(BIN)/python -m pytest -m slow --timeout=3600

test-matrix:  ## the add-on on Blender 4.2, 4.5, 5.0 and, with Python 3.13, 5.2 (SERIES=)
	@tools/test_matrix.sh $(SERIES)

test-ui:  ## in Blender's window: panels, nodes, F12 and ESC (BLENDER_GUI= names a Blender); pictures in artifacts/ui
	@$(SETUP) test
	$(BIN)/python -m pytest -m ui -rs --timeout=900 tests/ui

test-monkey:  ## ten minutes of random clicks and edits in Blender's window (MINUTES=, SEED=)
	@$(SETUP) test
	$(BIN)/python -m tests.ui.monkey --minutes $(MINUTES) --seed $(SEED)

package:  ## build and validate dist/dichromatic-<version>.zip
	@$(SETUP)
	$(BIN)/python tools/package.py

lint:  ## ruff and mypy
	@$(SETUP) test lint
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

format:  ## let ruff format and mend what it can
	@$(SETUP) lint
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

stability:  ## docs/stability.md: the worst errors of the reflection laws
	@$(SETUP)
	$(BIN)/python -m tools.stability_table

figures:  ## draw the figures of docs/figures again
	@$(SETUP) figures
	$(BIN)/python tools/make_figures.py

tables:  ## the tables in the pages of docs/: errors of the wavelength grids, error against time, the library (5 min)
	@$(SETUP) test figures
	$(BIN)/python -m tools.document_tables --timed

# Sampling and estimates take longest; BENCHMARKS="cycles mitsuba" runs some alone.
BENCHMARKS ?= tracing growth colour_cost relight sampling estimate_accuracy cancel cycles mitsuba
PLOTS := artifacts/bench

bench: SHELL := bash
bench: .SHELLFLAGS := -o pipefail -c
bench:  ## rays beside Embree, renders beside Cycles and Mitsuba, colour, growth, estimates (40 min; BENCHMARKS=)
	@$(SETUP) bench figures
	@$(SETUP) peers || echo "  Mitsuba cannot be installed here: what compares with it is left out"
	@mkdir -p $(PLOTS)
	@for name in $(BENCHMARKS); do \
	  plot=; case $$name in growth | sampling | mitsuba) plot="--plot $(PLOTS)/$$name.png" ;; esac; \
	  printf '\n== %s ==\n' $$name; $(BIN)/python -m tests.benchmarks.$$name $$plot || exit 1; \
	done | tee $(PLOTS)/tables.txt

gallery:  ## render sample_blends to the pictures of docs/gallery.md, 1280x720 (20 min; PICTURES= names some)
	@$(SETUP) figures
	$(BIN)/python -m tools.make_gallery $(PICTURES)

docs:  ## build the documents as a site in site/, and check its links
	@$(SETUP) docs
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --strict --quiet
	$(BIN)/python tools/check_links.py site

clean:  ## remove the environments and everything that was made
	rm -rf .venv .venv-* build dist renders site artifacts *.egg-info .mypy_cache .ruff_cache .pytest_cache .hypothesis
