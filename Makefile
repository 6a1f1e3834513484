# Everything a person or a machine does with the sources. `make demo` and `make test` install what is missing.

CARGO ?= cargo
# Where rustup puts it; a shell started before the installation does not look there.
export PATH := $(PATH):$(HOME)/.cargo/bin

.PHONY: help setup demo test check fuzz bench bench-quality bench-scale bench-kernels paper fmt accept

help:
	@echo 'make setup   install what is missing (Debian: GDAL, a C compiler, Python for one test)'
	@echo 'make demo    build, make a terrain, simplify, verify and draw it'
	@echo 'make test    all tests'
	@echo 'make check   formatting, lints and documentation, warnings denied'
	@echo 'make bench   the benchmark: against pydelatin and against GDAL alone'
	@echo 'make bench-quality  what every --quality is worth, against pydelatin'
	@echo 'make bench-scale    from 4096 x 4096 to 32768 x 32768 (choose: SIZES=4096,8192)'
	@echo 'make bench-kernels  the parts, by criterion'
	@echo 'make paper   repeats the experiments of Garland & Heckbert 1995, tables and plots'
	@echo 'make accept  the long acceptance run'
	@echo 'make fuzz    the fuzzers, two minutes each (choose: FUZZ_TARGETS=tiff FUZZ_SECONDS=600)'
	@echo 'make fmt     format the sources'

setup:
	@scripts/setup.sh

demo: setup
	$(CARGO) build --release --locked
	@scripts/demo.sh

test: setup
	$(CARGO) test --locked

check: setup
	$(CARGO) fmt --check
	$(CARGO) clippy --locked --all-targets -- -D warnings
	RUSTDOCFLAGS='-D warnings' $(CARGO) doc --locked --no-deps

bench: setup
	$(CARGO) build --release --locked --bin terrabite --example gdal_floor
	@python3 scripts/bench.py $(BENCH_OPTIONS)

bench-quality: setup
	$(CARGO) build --release --locked --bin terrabite --example gdal_floor
	@python3 scripts/bench_quality.py $(BENCH_OPTIONS)

bench-scale: setup
	$(CARGO) build --release --locked --bin terrabite --example gdal_floor
	@python3 scripts/bench_scale.py

bench-kernels: setup
	$(CARGO) bench --locked

paper: setup
	$(CARGO) build --release --locked --bin terrabite --example garland_heckbert
	@python3 scripts/paper.py

accept: setup
	$(CARGO) build --release --locked --bin terrabite --example cells
	scripts/accept.sh

# Nightly, and `cargo install cargo-fuzz`. What is new goes to fuzz/found, so that the corpus stays small.
FUZZ_TARGETS ?= ply chunk tiff simplify
FUZZ_SECONDS ?= 120
fuzz: setup
	@for target in $(FUZZ_TARGETS); do \
		mkdir -p fuzz/found/$$target && \
		$(CARGO) +nightly fuzz run --sanitizer none $$target fuzz/found/$$target fuzz/corpus/$$target -- \
			-max_total_time=$(FUZZ_SECONDS) -max_len=4096 -timeout=30 || exit 1; \
	done

fmt:
	$(CARGO) fmt
