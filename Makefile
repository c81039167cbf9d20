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

python: setup  ## the Python module, to be imported from build/release/python; pip install . installs it
	@told=$$(scripts/python_venv --needed) && cmake --preset release --log-level=WARNING $$told
	@cmake --build --preset release -j $(JOBS) --target isopach-python isopach-bin

# The module and its tests are left out, with a message, where pip cannot fetch what they are built with.
test: setup  ## all tests, those of the Python module, too; the last lines are ctest's own
	@cmake --preset release --log-level=WARNING $$(scripts/python_venv)
	@cmake --build --preset release -j $(JOBS)
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
