# Thin: every target is one or two commands that can be typed by hand. Needs bash, make and the network once, for set-up.
.DEFAULT_GOAL := build
.PHONY: setup build demo python test bench fuzz check format clean

JOBS ?= $(shell nproc)

setup:  ## install what is missing; quick when nothing is
	@scripts/setup.sh

build: setup
	@cmake --preset release --log-level=WARNING
	@cmake --build --preset release -j $(JOBS)

demo: setup  ## a comparison with known truth, and its report; builds the program alone
	@cmake --preset release --log-level=WARNING
	@cmake --build --preset release -j $(JOBS) --target isopach-bin
	@build/release/bin/isopach demo -o out/demo

# From then on `make test` runs its tests, too.
python: setup  ## the Python module, to be imported from build/release/python; pip install . installs it
	@test -x build/venv/bin/python || python3 -m venv build/venv
	@build/venv/bin/python -m pip install --quiet nanobind numpy pytest mypy
	@cmake --preset release --log-level=WARNING -DISOPACH_PYTHON=ON -DPython_EXECUTABLE=$(CURDIR)/build/venv/bin/python
	@cmake --build --preset release -j $(JOBS) --target isopach-python isopach-bin

test: build  ## all tests; the last lines are ctest's own
	@ctest --preset release -j $(JOBS)

bench: setup  ## builds for this machine, runs the experiments, writes docs/evidence/benchmark.md; BENCH=--quick for a minute
	@cmake --preset bench --log-level=WARNING
	@cmake --build --preset bench -j $(JOBS)
	@scripts/bench $(BENCH)

fuzz: setup  ## every fuzz target under sanitizers, for an hour each; FUZZ_SECONDS=600 for less
	@cmake --preset fuzz --log-level=WARNING
	@cmake --build --preset fuzz -j $(JOBS) --target isopach-fuzz
	@tests/fuzz/run build/fuzz $(or $(FUZZ_SECONDS),3600)

check:  ## the project's own rules
	@scripts/checks/all

format:
	@git ls-files '*.cpp' '*.hpp' | xargs clang-format -i

clean:
	@rm -rf build out
