# Set up, run, test and measure telespring; `make help` lists the targets.
#
# Needs Rust, Python with venv, a C compiler and make; tools/check-toolchain.sh checks for each of them first.
# Everything is installed into .venv, from the pinned versions in requirements/.

SHELL := /bin/sh
.DEFAULT_GOAL := help

VENV := .venv
STAMPS := $(VENV)/.stamps
PYTHON_IN_VENV := $(VENV)/bin/python
# Always build the binding with the same interpreter; with another one cargo would rebuild it.
export PYO3_PYTHON := $(CURDIR)/$(PYTHON_IN_VENV)
export VIRTUAL_ENV := $(CURDIR)/$(VENV)
export PIP_DISABLE_PIP_VERSION_CHECK := 1
export PIP_QUIET := 1

BINDING_SOURCES := Cargo.toml Cargo.lock pyproject.toml \
	$(shell find crates/telespring crates/telespring-py -name '*.rs' -o -name '*.toml')

# Recreate .venv if its set-up was interrupted, its folder was moved, or its Python no longer exists.
VENV_USABLE := $(shell [ ! -e $(VENV)/.unfinished ] && [ "$$(cat $(VENV)/.place 2>/dev/null)" = "$$(pwd)" ] \
	&& $(PYTHON_IN_VENV) -c '' 2>/dev/null && echo yes)
ifneq ($(VENV_USABLE),yes)
REMAKE := remake
endif

.PHONY: help study test link link-static test-link bench-link test-relay wheel check-wheel ros2 test-ros2 lint format verify oracles fuzz bench clean toolchain link-toolchain remake page test-page test-page-itself docs docs-check docs-toolchain

help: ## list the targets
	@sed -n 's/^\([a-z0-9-]*\):.*## \(.*\)/  make \1|\2/p' Makefile | awk -F'|' '{ printf "%-16s %s\n", $$1, $$2 }'

study: $(STAMPS)/binding ## set everything up and reproduce the paper in out/study/
	$(VENV)/bin/telespring reproduce

# The same generated cases on every machine; `make verify` draws new ones.
test: $(STAMPS)/binding $(STAMPS)/test ## set everything up and run all tests
	PROPTEST_RNG_SEED=20251121 cargo test --locked
	$(PYTHON_IN_VENV) -m pytest --numprocesses auto --maxprocesses 4 --dist worksteal

# One HTML file, and a copy in the package for `telespring explore`, notebooks and the wheel.
PAGE_CORE := out/page/telespring.wasm
page: toolchain ## build the page that needs no server, out/page/telespring.html
	tools/build-wasm.sh $(PAGE_CORE)
	"$$(tools/check-toolchain.sh --python)" tools/bundle_page.py $(PAGE_CORE) out/page/telespring.html
	mkdir -p python/telespring/assets
	cp out/page/telespring.html python/telespring/assets/telespring.html

# Needs Node.js; what looks at the page needs npm and Chromium. Each says loudly what it lacks.
test-page: test-page-itself ## test the page: its core against the native one, and in a browser
	$(PYTHON_IN_VENV) -m pytest tests/test_page_answers.py tests/test_answer_rule.py tests/test_explore.py

# The part of it that `make test` leaves out: where the page has been built, that runs the files above, too.
test-page-itself: page $(STAMPS)/binding $(STAMPS)/test
	cargo test --locked -p telespring-wasm
	@command -v npm >/dev/null || echo "SKIPPED: no npm: nobody has looked at the page"
	! command -v npm >/dev/null || (cd page/test && npm ci --no-audit --no-fund && \
		TELESPRING="$(CURDIR)/$(VENV)/bin/telespring" node --test)

# The live program is no default member of the workspace: what does not name it does not build it.
link: link-toolchain ## build the live program, target/release/telespring-link (Linux)
	cargo build --release --locked -p telespring-link

# One file without any library of the system, for a machine that has no Rust.
HOST := $(shell rustc -vV 2>/dev/null | sed -n 's/^host: //p')
link-static: link-toolchain ## build the live program as one static file, in target/HOST/release
	RUSTFLAGS='-C target-feature=+crt-static' cargo build --release --locked -p telespring-link --target $(HOST)
	"$$(tools/check-toolchain.sh --python)" tools/gather_licences.py telespring-link $(HOST) \
		>$${CARGO_TARGET_DIR:-target}/$(HOST)/release/telespring-link-licences.txt
	@printf '\n%s\n' 'On Linux it has the GNU C library in it (LGPL-2.1-or-later); `make link-static` of these sources links another one.' \
		>>$${CARGO_TARGET_DIR:-target}/$(HOST)/release/telespring-link-licences.txt
	@echo $${CARGO_TARGET_DIR:-target}/$(HOST)/release/telespring-link

# Real-time tests: they share the machine with nobody who can help it. Then what the package makes of the program and its recordings.
LINK_TESTED := $${CARGO_TARGET_DIR:-target}/link-test/telespring-link
test-link: link-toolchain $(STAMPS)/binding $(STAMPS)/test ## test the live program
	cargo test --profile link-test --locked -p telespring-link
	TELESPRING_LINK="$$(realpath "$(LINK_TESTED)")" \
		$(PYTHON_IN_VENV) -m pytest tests/test_connect.py tests/test_recordings_of_the_program.py

# iroh's relay server, of the version that the live program speaks with; no test needs its speed. Not in .ci/run: its hundreds of crates
# take minutes to build.
RELAY_VERSION := $(shell sed -n 's/^const VERSION: &str = "\(.*\)";/\1/p' crates/telespring-link/src/commands/relay_config.rs)
target/relay/bin/iroh-relay: crates/telespring-link/src/commands/relay_config.rs
	CARGO_PROFILE_DEV_DEBUG=0 cargo install iroh-relay --version $(RELAY_VERSION) --locked --features server --debug --root target/relay
	@touch $@

test-relay: link-toolchain target/relay/bin/iroh-relay ## test the live program with a relay server, which is built first (minutes)
	TELESPRING_RELAY=$(CURDIR)/target/relay/bin/iroh-relay \
		cargo test --profile link-test --locked -p telespring-link --test law_relay

bench-link: link-toolchain ## compare the live program with raw UDP and cyclictest (needs root and rt-tests)
	cargo bench --locked -p telespring-link --bench link

# A workspace of its own, for its many dependencies; its tests need no ROS 2.
ros2: link-toolchain ## build the bridge to ROS 2, drivers/ros2/target/release/telespring-ros2
	cargo build --release --locked --manifest-path drivers/ros2/Cargo.toml

test-ros2: link-toolchain ## lint and test the bridge to ROS 2
	cargo fmt --manifest-path drivers/ros2/Cargo.toml --check
	cargo clippy --all-targets --locked --manifest-path drivers/ros2/Cargo.toml -- -D warnings
	cargo test --locked --manifest-path drivers/ros2/Cargo.toml

lint: $(STAMPS)/test ## check formatting, warnings, types and imports between rooms
	cargo fmt --all --check
	cargo clippy --workspace --all-targets --locked -- -D warnings
	$(PYTHON_IN_VENV) -m ruff check .
	$(PYTHON_IN_VENV) -m ruff format --check .
	$(PYTHON_IN_VENV) -m mypy
	# what only other systems have, or lack
	$(PYTHON_IN_VENV) -m mypy --platform win32 --no-warn-unreachable --cache-dir .mypy_cache/win32 python/telespring
	PYTHONPATH=python $(VENV)/bin/lint-imports --no-cache --no-logo
	$(PYTHON_IN_VENV) tools/check_imports.py

format: $(STAMPS)/test ## apply the formatting that lint checks
	cargo fmt --all
	$(PYTHON_IN_VENV) -m ruff check --fix .
	$(PYTHON_IN_VENV) -m ruff format .

# Old systems and other machines: zig is compiler and linker. Changed sources only are built anew, in target/wheel.
# WITHOUT_PAGE=1 builds a wheel without the page, where the library of Rust for WebAssembly cannot be had: no release.
export WITHOUT_PAGE
wheel: $(if $(WITHOUT_PAGE),,page) $(STAMPS)/wheel ## build the wheel and the source distribution, in out/wheel
	rm -rf out/wheel $(if $(WITHOUT_PAGE),python/telespring/assets/telespring.html)
	tools/build-wheel.sh out/wheel

check-wheel: wheel ## build the wheel twice, compare, install it without Rust, and use it
	tools/check-wheel.sh out/wheel --twice

# Every run draws new cases from a seed, which it prints; `make verify SEED=...` repeats them.
SEED := $(shell od -An -N4 -tu4 /dev/urandom | tr -d ' ')
verify: export PROPTEST_RNG_SEED := $(SEED)
verify: export TELESPRING_VERIFY := $(SEED)
verify: $(STAMPS)/binding $(STAMPS)/oracles ## run large random comparisons (minutes to hours)
	@echo "drawing new cases from $(SEED); repeat them with 'make verify SEED=$(SEED)'"
	cargo test --locked --release -- --include-ignored
	$(PYTHON_IN_VENV) -m pytest tests/test_laws.py --hypothesis-seed $(SEED) --timeout 0
	$(PYTHON_IN_VENV) -m pytest -m verify --timeout 0

oracles: $(STAMPS)/oracles ## install other programs to compare with

bench: $(STAMPS)/binding $(STAMPS)/oracles ## compare speed and accuracy with other programs
	$(PYTHON_IN_VENV) benches/run.py

FUZZ_SECONDS := 60
fuzz: toolchain ## run each fuzzer for FUZZ_SECONDS (needs nightly Rust and cargo-fuzz)
	@cargo +nightly --version >/dev/null 2>&1 || \
		{ echo "make fuzz needs nightly Rust: install it with 'rustup toolchain install nightly'." >&2; exit 1; }
	@cargo +nightly fuzz --version >/dev/null 2>&1 || \
		{ echo "make fuzz needs cargo-fuzz: install it with 'cargo install cargo-fuzz'." >&2; exit 1; }
	@set -e; for target in $$(cargo +nightly fuzz list); do \
		echo "fuzzing $$target for $(FUZZ_SECONDS) s"; \
		cargo +nightly fuzz run $$target -- -max_total_time=$(FUZZ_SECONDS); \
	done

# What has not changed is not made anew: pages and pictures (Sphinx, sphinx-gallery), the page, the crate's documentation (cargo).
docs: $(STAMPS)/binding $(STAMPS)/docs docs/node_modules/.package-lock.json ## build the documentation site, out/docs/index.html (needs Node.js)
	@if tools/build-wasm.sh --ready; then $(MAKE) --no-print-directory page; \
		else echo "NO PAGE: 'Try it' of the site is what 'make page' made last, or says how to make it" >&2; fi
	$(VENV)/bin/sphinx-build --builder html --fail-on-warning --keep-going --quiet -d out/docs-doctrees docs out/docs
	RUSTDOCFLAGS='-D warnings' cargo doc --locked --no-deps --package telespring
	rm -rf out/docs/rust && cp -r $${CARGO_TARGET_DIR:-target}/doc out/docs/rust

docs-check: docs ## look at every page of the site in a browser: accessibility, width, requests (needs Chromium)
	node tools/site/look.mjs out/docs

clean: ## remove everything that was built (not out/)
	rm -rf $(VENV) target docs/node_modules docs/_generated fuzz/target benches/rust/target drivers/*/.venv drivers/ros2/target .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find python tests drivers -name __pycache__ -type d -prune -exec rm -rf {} +
	rm -f python/telespring/_core*.so

toolchain:
	@tools/check-toolchain.sh

docs-toolchain:
	@tools/check-toolchain.sh --docs

link-toolchain:
	@tools/check-toolchain.sh --link

remake:

# Order-only: the check runs first every time but never makes .venv out of date.
$(STAMPS)/run: requirements/run.txt $(REMAKE) | toolchain
	@# A changed pin recreates .venv, so that packages dropped from the list are removed, too.
	rm -rf $(VENV)
	tools/make-venv.sh requirements/run.txt
	@mkdir -p $(STAMPS) && touch $@

$(STAMPS)/test: requirements/test.txt $(STAMPS)/run
	tools/make-venv.sh requirements/test.txt
	@touch $@

$(STAMPS)/wheel: requirements/wheel.txt $(STAMPS)/run
	tools/make-venv.sh requirements/wheel.txt
	@touch $@

$(STAMPS)/oracles: requirements/oracles.txt $(STAMPS)/test
	tools/make-venv.sh requirements/oracles.txt
	@touch $@

$(STAMPS)/docs: requirements/docs.txt $(STAMPS)/test
	tools/make-venv.sh requirements/docs.txt
	@touch $@

docs/node_modules/.package-lock.json: docs/package.json docs/package-lock.json | docs-toolchain
	npm ci --prefix docs --ignore-scripts --no-audit --no-fund --silent
	@touch $@

$(STAMPS)/binding: $(BINDING_SOURCES) $(STAMPS)/run
	$(VENV)/bin/maturin develop --release --locked
	@touch $@
