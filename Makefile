# Every target does its own set-up: Python 3.11 or newer and make are all that is needed.
# Stamps in .venv make a repeated run quick; they are remade when pyproject.toml changes.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# Wheels rather than sources: the mesher of sections has some that need a compiler. Of twelve thousand modules that come
# with them a third is ever imported: Python compiles those then.
PIP := $(BIN)/python -m pip --disable-pip-version-check install --quiet --prefer-binary --no-compile
WORKERS ?= 2
PYTEST := $(BIN)/python -m pytest -n $(WORKERS)
# A worker takes whole modules, so that what the tests of a module share is computed once.
SUITE := $(PYTEST) --dist loadscope
COMPILATION := tests/unit/test_warmup.py
# Without byte code on disk Python would compile this package again in every process.
unexport PYTHONDONTWRITEBYTECODE

.DEFAULT_GOAL := help
.PHONY: help demo quick test numba release coverage search fuzz honest check style types pages kernels docs figures bench peers clean

help:
	@echo "make demo   run examples/cantilever_swing.toml; pictures and data in out/cantilever_swing"
	@echo "make quick  unit and property tests but the slow ones: a minute, once kernels are compiled"
	@echo "make test   all checks and all tests"
	@echo "make numba  kernels of elements with four versions of Numba, each in an environment of its own"
	@echo "make coverage  tests of kernels in pure Python, as before every release: how many lines of the mechanics they reach"
	@echo "make search property tests with new random examples"
	@echo "make fuzz   10 000 damaged versions of every shipped case, 1000 of every kind of result, damaged journals, interrupts (hours)"
	@echo "make check  ruff, mypy, import contracts, documentation with warnings as errors"
	@echo "make honest 1000 random models by default against refined solutions: how many are wrong without a word (an hour)"
	@echo "make docs   documentation in docs/_build/html"
	@echo "make figures  draw the pictures of the documentation again and print its tables"
	@echo "make bench  timings, as ratios"
	@echo "make release  wheels (with machine code too) and sdist in dist/, installed and used in empty environments"
	@echo "make peers  the same motions computed by other programs: time against error"
	@echo "make clean  remove everything that was made here, the environment too"

$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "viscorod needs Python 3.11 or newer; name one with: make PYTHON=python3.12 $(MAKECMDGOALS)"; exit 1; }
	$(PYTHON) -m venv $(VENV)

$(VENV)/.stamp-run: pyproject.toml | $(BIN)/python
	$(PIP) --editable .
	@touch $@

$(VENV)/.stamp-test: pyproject.toml | $(BIN)/python
	$(PIP) --editable '.[test]'
	@touch $@ $(VENV)/.stamp-run

demo: $(VENV)/.stamp-run
	$(BIN)/viscorod run examples/cantilever_swing.toml -o out/cantilever_swing

# Types and documentation take a minute each: they are checked beside each other.
check: style
	$(MAKE) --no-print-directory --jobs=$(WORKERS) --output-sync=target types pages

style: $(VENV)/.stamp-test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(VENV)/.stamp-test
	$(BIN)/mypy
	$(BIN)/python docs/typed_lines.py docs/_build/typed
	$(BIN)/mypy docs/_build/typed/docs_lines
	MYPYPATH=docs $(BIN)/mypy --explicit-package-bases docs/figures
	$(BIN)/lint-imports

pages: $(VENV)/.stamp-test
	$(BIN)/sphinx-build -W --keep-going -q -b html docs docs/_build/html

quick: $(VENV)/.stamp-test
	$(SUITE) -m "not slow" tests/unit tests/property

# All kernels are compiled first, which is a test and keeps one core busy as long as the checks keep another; the other
# tests find them on disk.
test: style
	$(MAKE) --no-print-directory --jobs=$(WORKERS) --output-sync=target kernels types pages
	$(SUITE) --durations=15 --ignore=$(COMPILATION)

kernels: $(VENV)/.stamp-test
	$(BIN)/python -m pytest --durations=15 $(COMPILATION)

# Tests of kernels, in pure Python: lines of compiled code cannot be counted.
KERNEL_TESTS := $(patsubst %,tests/unit/test_%.py,element_kernels collocation_kernels intrinsic_kernels motion_kernels \
  joint_coordinates settled_multipliers load_courses table_motions angular_variation assembly_tangent system_tangent block_matrices direct_solvers tableau callback)
MACHINE_CODE := tests/unit/test_direct_solvers.py::test_machine_code_on_disk_calls_the_functions_of_this_process
# High orders and lattices take a minute in pure Python, and reach no line that low orders and chains do not.
REACHING_NO_MORE := lattice or high or match_finite_differences[4-

coverage: $(VENV)/.stamp-test
	$(BIN)/coverage erase
	NUMBA_DISABLE_JIT=1 $(BIN)/coverage run -m pytest -n $(WORKERS) $(KERNEL_TESTS) --deselect $(MACHINE_CODE) \
	  -k 'not ($(REACHING_NO_MORE))'
	$(BIN)/coverage combine --quiet
	$(BIN)/coverage report

# The kernels of elements, in machine code, with versions of Numba whose inner classes differ.
NUMBAS ?= 0.61 0.64 0.66 0.68
numba: | $(BIN)/python
	set -e; for version in $(NUMBAS); do \
	  $(PYTHON) -m venv --clear $(VENV)/numba; \
	  $(VENV)/numba/bin/python -m pip install --quiet --prefer-binary --editable . "numba==$$version.*" 'pytest>=8.3' 'hypothesis>=6.112'; \
	  $(VENV)/numba/bin/python -m pytest -q -p no:cacheprovider tests/unit/test_element_kernels.py tests/unit/test_machine_code.py; \
	done

search: $(VENV)/.stamp-test
	$(PYTEST) tests/property --hypothesis-profile=search

fuzz: $(VENV)/.stamp-test
	$(PYTEST) tests/property/test_fuzz_runs.py tests/property/test_fuzz_journals.py tests/property/test_damaged_results.py --hypothesis-profile=fuzz

honest: $(VENV)/.stamp-test
	PYTHONPATH=tests $(BIN)/python -m honesty --workers $(WORKERS)

docs: $(VENV)/.stamp-test
	PATH="$(CURDIR)/$(BIN):$$PATH" VISCOROD_NOTEBOOKS=cache $(BIN)/sphinx-build -W --keep-going -q -b html docs docs/_build/html
	@echo "docs/_build/html/index.html"

figures: $(VENV)/.stamp-test
	set -e; for script in docs/figures/*.py; do echo "$$script"; $(BIN)/python $$script; done

bench: $(VENV)/.stamp-test
	$(BIN)/python bench/newton_iteration.py
	$(BIN)/python bench/model_sizes.py
	$(BIN)/python bench/large_models.py
	$(BIN)/python bench/linear_solvers.py
	$(BIN)/python bench/formulations.py
	$(BIN)/python bench/assemblies.py
	$(BIN)/python bench/mesh_accuracy.py
	$(BIN)/python bench/tolerance.py
	$(BIN)/python bench/statics.py
	$(BIN)/python bench/stability.py
	$(BIN)/python bench/periodic_motions.py
	$(BIN)/python bench/sweep.py
	$(BIN)/python bench/startup.py
	$(BIN)/python bench/published_times.py

peers: $(VENV)/.stamp-test
	$(PIP) --editable '.[bench]'
	$(BIN)/python bench/work_precision.py --figure docs/images/work_precision.png

# Nothing of this package is needed to build it; what the machine code is made with comes with the build. It is tried with
# the oldest and the newest Python that it is for, where they are installed.
PYTHONS ?= $(shell for version in 3.11 3.13; do python$$version -c '' 2>/dev/null && command -v python$$version; done)
release: coverage | $(BIN)/python
	$(PIP) 'build>=1.2' 'twine>=6.0'
	rm -rf dist
	$(BIN)/python -m build --outdir dist .
	HATCH_BUILD_HOOK_ENABLE_CUSTOM=1 $(BIN)/python -m build --wheel --outdir dist .
	$(BIN)/twine check --strict dist/*
	$(BIN)/python packaging/check_release.py $(PYTHONS)

clean:
	rm -rf $(VENV) out docs/_build build dist .pytest_cache .mypy_cache .ruff_cache .import_linter_cache .hypothesis
	find src tests bench docs -name __pycache__ -type d -prune -exec rm -rf {} +
