# The two commands of the README are `make demo` and `make test`; `make help` lists the rest.
SHELL := /bin/bash
.DELETE_ON_ERROR:
.DEFAULT_GOAL := help

PY  := .venv/bin/python
PY52 := .venv-5.2/bin/python
TOGISHI := build/release/cpp_core/cli/togishi
CORE_SOURCES := $(shell find cpp_core shaders data cmake -type f 2>/dev/null) CMakeLists.txt pyproject.toml
SAY := . tools/say.sh; say

.PHONY: help setup setup-5.2 build command core core-5.2 demo test test-cpp test-python core-5.2-where-possible test-package test-window package \
        docs-pictures results lint sanitize format clean

help: ## list the targets
	@grep -hE '^[a-z0-9.-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 20

setup: ## install what is missing (apt.txt, .venv with bpy 4.5 LTS, meshoptimizer's sources)
	@tools/setup_debian.sh
	@tools/setup_python.sh .venv 3.11 blender-4-5 test dev
	@tools/setup_meshoptimizer.sh

setup-5.2: setup
	@tools/setup_python.sh .venv-5.2 3.13 blender-5-2 test

build: setup ## build the togishi command and the C++ tests
	@$(SAY) "building the C++ core"
	@cmake --preset release >/dev/null
	@cmake --build --preset release

# The module is rebuilt and installed only when something that it is made of has changed. CXX: the name under which
# CMake's presets know the compiler, so that ccache finds their objects.
define install_core
	@$(SAY) "building the Python module for $(1)"
	@CXX=c++ $(1) -m pip install --disable-pip-version-check -q --no-deps --no-build-isolation --force-reinstall . \
	    || { . tools/say.sh; fail "the module togishi_core did not build for $(1): the compiler's message is above."; }
	@mkdir -p build && touch $@
endef

core: setup
	@$(MAKE) --no-print-directory build/core-4.5.stamp
build/core-4.5.stamp: $(CORE_SOURCES)
	$(call install_core,$(PY))
core-5.2: setup-5.2
	@$(MAKE) --no-print-directory build/core-5.2.stamp
build/core-5.2.stamp: $(CORE_SOURCES)
	$(call install_core,$(PY52))

# Only what the demo runs: the tests' programs are half of the whole build.
command: setup
	@$(SAY) "building the togishi command"
	@cmake --preset release >/dev/null
	@cmake --build --preset release --target togishi

demo: command core ## the main job on real input: pictures and a page in out/demo
	@$(SAY) "rendering the demo into out/demo"
	@$(PY) blend_files/demo/make_demo.py --out out/demo
	@$(SAY) "done: open out/demo/index.html"

# Not among them: `make package` (downloads zig) and `make test-window` (unpacks a second Debian).
test: test-cpp test-python ## all tests but test-window
	@$(SAY) "all tests passed. Figures: make results; pictures: make demo"

test-cpp: build
	@$(SAY) "C++ tests"
	@ctest --preset release --progress

# 5.2 LTS needs Python 3.13, which Debian 12 lacks: without it `make test` says so, and CI fails.
core-5.2-where-possible:
	@if [ -n "$$CI" ] || [ -x $(PY52) ] || compgen -G "$$HOME/.pyenv/versions/3.13*" >/dev/null || command -v python3.13 >/dev/null; then \
	    $(MAKE) --no-print-directory core-5.2; \
	else \
	    $(SAY) "SKIPPED: Blender 5.2 LTS needs Python 3.13, and none was found. Only Blender 4.5 LTS is tested."; \
	fi

# The package is tested around the modules that `make core` installed, so that neither this nor CI needs zig.
ZIP ?=
PACKAGE_45 = "package in 4.5=$(PY) -m pytest -q tests/package -k 'not 5.2'"
PACKAGE_52 = "package in 5.2=$(PY) -m pytest -q tests/package -k 5.2"
SIDE_BY_SIDE = TOGISHI_PACKAGE=$(ZIP) $(PY) tools/side_by_side.py --logs build/tests
HERE = env PYTHONPATH=addon TOGISHI_CLI=$(abspath $(TOGISHI))
test-python: build core core-5.2-where-possible
	@tools/setup_openimageio.sh
	@$(SAY) "Python tests, tests inside Blender, and the extension installed into clean Blenders; logs in build/tests"
	@two=(); [ ! -x $(PY52) ] || two=("Blender 5.2=$(HERE) $(PY52) -m pytest -q tests/blender" $(PACKAGE_52)); \
	$(SIDE_BY_SIDE) "Blender 4.5=$(HERE) $(PY) -m pytest -q tests/blender" "$${two[@]:0:1}" \
	    "Python=$(HERE) $(PY) -m pytest -q tests/python" $(PACKAGE_45) "$${two[@]:1}"

test-package: core core-5.2-where-possible ## the extension installed into clean Blenders: 4.5 LTS, and 5.2 LTS where core-5.2 is (ZIP=dist/F.zip: this package)
	@tools/setup_openimageio.sh
	@$(SAY) "the extension installed into clean Blenders"
	@$(SIDE_BY_SIDE) $(PACKAGE_45) $(PACKAGE_52)

test-window: core-5.2 ## the extension in a real window of trixie's Blender; pictures in out/window (ZIP=dist/F.zip: this package)
	@tools/setup_debian.sh apt-window.txt
	@zip="$(ZIP)"; [ -n "$$zip" ] || zip=$$($(PY) tools/package/make_package.py --installed --out build/extension) && tools/test_window.sh "$$zip"

PYTHONS ?= 3.11 3.13
COMPILER ?= zig
package: setup ## the extension to give away, into dist (PYTHONS="3.11 3.13"; COMPILER=g++ instead of zig: not for older systems)
	@tools/setup_python.sh .venv-package 3.11 package
	@. tools/say.sh; pythons=(); for version in $(PYTHONS); do \
	    python=$$(tools/find_python.sh $$version) || fail "Python $$version was not found on PATH or in ~/.pyenv. Install it, or leave it out of PYTHONS."; \
	    pythons+=(--python $$version=$$python); \
	done; .venv-package/bin/python tools/package/make_package.py --compiler $(COMPILER) "$${pythons[@]}"

docs-pictures: core ## the user guide's pictures from this build (and panels from out/window); look at them before a commit
	@$(SAY) "rendering the guide's pictures into docs/guide/pictures"
	@PYTHONPATH=addon $(PY) blend_files/docs_pictures.py

AREA ?=
results: build core ## measure everything; lists the rows that miss their bound (AREA=viewport: one area)
	@$(PY) tests/bench/results.py $(if $(AREA),--area $(AREA))

lint: build core ## formatters and linters, clean or not
	@tools/lint.sh

format: setup ## format everything
	@find cpp_core tests -name '*.hpp' -o -name '*.cpp' | xargs clang-format -i
	@.venv/bin/ruff format -q . && .venv/bin/ruff check -q --fix .

sanitize: setup ## C++ tests under address and undefined-behaviour sanitizers
	@$(SAY) "C++ tests under the sanitizers"
	@cmake --preset asan-ubsan >/dev/null && cmake --build --preset asan-ubsan && ctest --preset asan-ubsan --progress

clean: ## remove what was built (not the environments)
	rm -rf build out dist
