# Everything sets itself up: a first `make demo` or `make test` builds .venv with pip; for the demo
# alone, without what only tests and extras need.
PYTHON ?= python3
BIN := .venv/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check

.PHONY: demo test test-fast test-slow test-lowest lint bench docs docs-site fresh clean

demo: .venv/package
	$(BIN)/avsec demo

# A thread for each of the two processes: more would wait for one another's cores, three times as
# long in tests of networks.
PYTEST := OMP_NUM_THREADS=1 $(BIN)/python -m pytest -n 2 --dist loadfile $(if $(ROUND),--no-loadscope-reorder)
test: .venv/installed
	$(PYTEST)

test-fast: .venv/installed
	$(PYTEST) -m "not slow"

test-slow: .venv/installed
	$(PYTEST) -m slow

# What computes in floating point once more, with the arithmetic of a processor of 2008: without AVX,
# torch, oneDNN, MKL and OpenBLAS add up in another order, and other last digits come out. Left out are
# the parity with the originals' outputs, as long as all the rest and with tolerances of its own, and
# what computes nothing: processes that prepare batches, and files of weights.
LOWEST := ATEN_CPU_CAPABILITY=default ONEDNN_MAX_CPU_ISA=SSE41 MKL_ENABLE_INSTRUCTIONS=SSE4_2 \
	OPENBLAS_CORETYPE=Prescott
NUMERICAL := tests/perception tests/attacks tests/validation/evidence tests/validation/likelihood \
	tests/validation/repair tests/validation/connected/surfaces tests/validation/test_*.py \
	--ignore tests/perception/test_parity.py --ignore tests/perception/training/test_batches.py \
	--ignore tests/perception/weights
test-lowest: .venv/installed
	$(LOWEST) $(PYTEST) -m "$(if $(SLOW),,not slow)" $(NUMERICAL)

lint: .venv/installed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy --num-workers 2
	$(BIN)/lint-imports --no-logo --no-cache
	$(BIN)/python docs/words.py
	$(BIN)/python -m studies check

bench: .venv/installed
	$(BIN)/python benchmarks/ghost_object.py
	$(BIN)/python benchmarks/closed_loop.py
	$(BIN)/python benchmarks/evaluate.py
	$(BIN)/python benchmarks/layouts.py
	$(BIN)/python benchmarks/validation.py

# Pages and pictures of the documentation, anew: `make docs STUDIES="world driving_safety"
# DATA="--kitti DIR --scenarios DIR --detections DIR"`; studies/README.md lists them.
STUDIES ?= pictures world_benchmark detectors
docs: .venv/installed
	$(BIN)/python -m studies $(STUDIES) $(DATA)

# The documentation as a site, in out/site/html; `make docs-site FILMS=1` renders an episode of each environment, too.
docs-site: .venv/installed
	$(BIN)/python docs/site $(if $(FILMS),--films)

# Forget compiled numba kernels.
fresh:
	find avsec_gym -name __pycache__ -type d -prune -exec rm -rf {} +

clean: fresh
	rm -rf .venv

# torch comes first and by itself: pinned, pip takes the CPU build where one is offered.
# `make INSTALL=--no-compile` leaves 18,000 files to be compiled when they are imported, if they are.
INSTALL ?=
.venv/installed: .venv/package
	$(PIP) install --quiet $(INSTALL) -e '.[dev,docs,view,train,adversarial,distributed,rerun,video]' -c constraints.txt
	touch $@

.venv/package: pyproject.toml constraints.txt
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "avsec-gym needs Python 3.11 or newer: make PYTHON=python3.11 ...")'
	$(PYTHON) -m venv .venv
	$(PIP) install --quiet $(INSTALL) "$$(grep '^torch==' constraints.txt)" -c constraints.txt
	$(PIP) install --quiet $(INSTALL) -e . -c constraints.txt
	touch $@
