# Everything a person or a machine does with the sources. `make demo` and `make test` install what is missing.

CARGO ?= cargo
# Where rustup puts it; a shell started before the installation does not look there.
export PATH := $(PATH):$(HOME)/.cargo/bin

# A Python that makes environments.
PYTHON = $$(scripts/any_python.sh)

.PHONY: help setup demo test test-long test-readers test-browser viewer wheel check checksums fuzz bench bench-quality bench-scale bench-kernels pictures paper fmt accept

help:
	@echo 'make setup   install what is missing (Debian: GDAL, a C++ compiler, programs that read meshes for tests)'
	@echo 'make demo    build, make a terrain, simplify, verify and draw it'
	@echo 'make test    all tests, those of the Python package among them'
	@echo 'make test-long  the same, and random cases by the thousand, others every time'
	@echo 'make test-readers  meshes of every format in PyVista, Open3D, pymeshlab, xugrid, uxarray, geopandas and QGIS (2.5 GB once),'
	@echo '                   and tiles in the decoders of HERE and loaders.gl'
	@echo 'make test-browser  in headless Chromium (Debian) the pages of --report and view, and sets of tiles in CesiumJS (npm)'
	@echo 'make viewer  bundles the view of those pages anew (node, and three.js, meshoptimizer and esbuild from npm)'
	@echo 'make wheel   the Python package for any Linux with glibc 2.17 or newer, in target/wheels, tried in a clean environment'
	@echo 'make check   formatting, lints and documentation, warnings denied'
	@echo 'make bench   the benchmark: against pydelatin and against GDAL alone; what the Python package takes'
	@echo 'make bench-quality  what every --quality is worth, against pydelatin'
	@echo '                    (choose: BENCH_OPTIONS="--against REV", a commit to compare with;'
	@echo '                    BENCH_OPTIONS=--looks, only whether seams and the rim can be seen;'
	@echo '                    BENCH_OPTIONS=--budgets, only what budgets of triangles come to)'
	@echo 'make pictures  docs/images/looks-*.png, meshes of two builds shaded, and breaklines-*.png (choose: PICTURES_OPTIONS="--before REV")'
	@echo 'make bench-scale    from 4096 x 4096 to 32768 x 32768 (choose: SIZES=4096,8192)'
	@echo 'make bench-kernels  the parts, by criterion'
	@echo 'make paper   repeats the experiments of three papers, tables and plots'
	@echo 'make accept  the long acceptance run (choose: KILLS=1000)'
	@echo 'make checksums  of the meshes of many runs: the same before and after a change, unless it is meant to change meshes'
	@echo '                (choose: TERRABITE=/path/to/another/build)'
	@echo 'make fuzz    the fuzzers, two minutes each (choose: FUZZ_TARGETS=tiff FUZZ_SECONDS=600)'
	@echo 'make fmt     format the sources'

setup:
	@scripts/setup.sh

demo: setup
	$(CARGO) build --release --locked
	@scripts/demo.sh

# Simplifies and verifies an array with the library alone: no GDAL, no command.
CORE_TEST = mkdir -p target/tmp && $(CARGO) run --locked --profile test --no-default-features --example array -- target/tmp/array.ply

# The package of python/, installed from a wheel, by pytest and mypy.
PYTHON_TEST = $(PYTHON) scripts/python_tests.py

# The random cases of properties are the same every time, so that what fails was not like that before. Others: PROPTEST_RNG_SEED=1.
test: export PROPTEST_RNG_SEED ?= 1995
test: setup
	$(CARGO) test --locked
	$(CORE_TEST)
	@$(PYTHON_TEST)

# The same tests: random ones with other cases every time, four times as many and more, and rasters of several tiles where one does.
test-long: setup
	TERRABITE_LONG_TESTS=1 $(CARGO) test --locked
	$(CORE_TEST)
	@TERRABITE_LONG_TESTS=1 $(PYTHON_TEST)

# Programs that others wrote, which take minutes to install: PyPI's in an environment under target/, QGIS from Debian.
test-readers: setup
	$(CARGO) build --release --locked --bin terrabite
	@scripts/setup_readers.sh
	@python3 scripts/readers.py
	@python3 scripts/tiles_readers.py
	@$(PYTHON_TEST) --readers

# The pages of reports, and tiles in CesiumJS, in a browser. PROFILE=debug takes a build for tests.
test-browser: setup
	$(CARGO) build --release --locked --bin terrabite
	@scripts/setup_browser.sh
	@python3 scripts/browser_tests.py
	@python3 scripts/cesium_tests.py

# The program that draws the view of pages, from viewer/src and the packages of viewer/package-lock.json.
viewer:
	cd viewer && npm ci --ignore-scripts --no-audit --no-fund && node build.mjs

wheel: setup
	@$(PYTHON_TEST) --wheel

check: setup
	$(CARGO) fmt --all --check
	$(CARGO) clippy --locked --all-targets -- -D warnings
	$(CARGO) clippy --locked -p terrabite-python -- -D warnings
	$(CARGO) clippy --locked --no-default-features --lib --example array -- -D warnings
	RUSTDOCFLAGS='-D warnings' $(CARGO) doc --locked --no-deps

bench: setup
	$(CARGO) build --release --locked --bin terrabite --example gdal_floor
	@python3 scripts/bench.py $(BENCH_OPTIONS)
	@$(PYTHON) scripts/bench_python.py

bench-quality: setup
	$(CARGO) build --release --locked --bin terrabite --example gdal_floor --example looks
	@python3 scripts/bench_quality.py $(BENCH_OPTIONS)

bench-scale: setup
	$(CARGO) build --release --locked --bin terrabite --example gdal_floor
	@python3 scripts/bench_scale.py

pictures: setup
	$(CARGO) build --release --locked --bin terrabite
	@python3 scripts/pictures.py $(PICTURES_OPTIONS)
	@python3 scripts/pictures_breaklines.py

bench-kernels: setup
	$(CARGO) bench --locked

paper: setup
	$(CARGO) build --release --locked --bin terrabite --example garland_heckbert --example silva_agarwal
	@python3 scripts/paper.py
	@python3 scripts/paper_windows.py

accept: setup
	$(CARGO) build --release --locked --bin terrabite --example cells
	scripts/accept.sh

# Another build has been built already.
checksums:
	@scripts/setup.sh >&2
	@test -n '$(TERRABITE)' || $(CARGO) build --release --locked --bin terrabite
	@scripts/checksums.py

# Nightly, and `cargo install cargo-fuzz`. What is new goes to fuzz/found, so that the corpus stays small.
FUZZ_TARGETS ?= ply obj glb stl landxml ugrid vtp sms_2dm chunk tiff simplify
FUZZ_SECONDS ?= 120
fuzz: setup
	@for target in $(FUZZ_TARGETS); do \
		mkdir -p fuzz/found/$$target && \
		$(CARGO) +nightly fuzz run --sanitizer none $$target fuzz/found/$$target fuzz/corpus/$${target#sms_} -- \
			-max_total_time=$(FUZZ_SECONDS) -max_len=4096 -timeout=30 || exit 1; \
	done

fmt:
	$(CARGO) fmt --all
