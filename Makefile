# make bench | board-picture | page-picture | board-pages | advice | test | test-all | docs | reproduce | verdicts | diagnosis-reports | exam-report | indices-report | rates | ugly | wrong-data | fuzz | timing | fit-times | lint | types | format | env | clean

PYTHON ?= $(shell for p in python3 python3.14 python3.13 python3.12 python3.11; do \
	$$p -c 'import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && echo $$p && break; done)
WORKERS ?= 2
FUZZ_SECONDS ?= 600

# Containers often set this; then every process that is started compiles all that it imports anew, which takes seconds.
unexport PYTHONDONTWRITEBYTECODE

BIN := .venv/bin
RESULTS := out/quick
REPRODUCTION := out/reproduction
RATES := out/rates
RATE_ROUNDS ?= 2
TIMES := out/timing.json
ROWS := out/timing/rows.jsonl
STAMP := .venv/installed-at
BOARD := leaderboard.html results.parquet parameters.parquet environment.json
BOARD += $(BOARD:%=minutes/%)
TOOLS := build/tools
ENTRANTS := innovations residual-bic sparse-regression best-fit nothing
EXAM_WORLDS ?= 12
EXAM_SEED ?= 1
SUITES ?= default measured mismatch channels generalise noise outliers disturbances sampling excitation tuners
ROOMS := models datasets checks estimation methods diagnosis bench reporting reproduction

DRAWN_SEED := $(or $(HELMBENCH_SEED),$(shell od -An -N3 -tu4 /dev/urandom | tr -d ' '))

# An environment holds absolute paths: when the checkout has moved, build it again.
ifneq ($(shell test "$$(cat $(STAMP) 2>/dev/null)" = "$$(pwd -P)" && echo here),here)
.PHONY: $(STAMP)
endif

.PHONY: help env bench board-picture page-picture docs reproduce verdicts diagnosis-reports exam-report indices-report test every-behaviour test-all lint types format rates ugly wrong-data fuzz timing fit-times clean hashes audit \
	browser compiler reports board-pages reproduction-pages asset dist packages sizes image
.DELETE_ON_ERROR:

help:
	@echo "make bench    install, run the quick suite, write the report to $(RESULTS), print headline and ranking"
	@echo "make board-picture  the same, and draw the standings for the README: reports/leaderboard/quick.svg"
	@echo "make test     install, lint, check types, test every behaviour once with fixed seeds: before every push"
	@echo "make test-all  all tests with drawn seeds, and the rates: nightly and before a release; HELMBENCH_SEED=N repeats"
	@echo "make docs     build the documentation site in docs/_build; nothing is loaded from the network"
	@echo "make page-picture  the picture of the page in the browser, for the documentation: docs/_static/page.png"
	@echo "make reproduce  compute the tables of the five papers, write the pages to reports/reproduction"
	@echo "make reproduction-pages   judge the stored results of reports/reproduction again, write its pages"
	@echo "make verdicts   reproduce once more with another seed: at most 2 % of the verdicts may change, no headline"
	@echo "make rates    draw every expectation of the diagnosis many times, compare the rates with what is promised;"
	@echo "              run the suite of imperfect base models (RATE_ROUNDS=2) into $(RATES), with its report"
	@echo "make ugly     give identify, diagnose and calibrate 300 ugly records: each ends in a result or in one line"
	@echo "make wrong-data   give every command records that are wrong in a known way: told, refused or harmless, no name of a hull"
	@echo "make fuzz     change valid files of every reader at random, FUZZ_SECONDS=600 each: none may crash, hang or run code"
	@echo "make timing   compare speed and memory with other implementations and the targets, write reports/timing"
	@echo "make fit-times  time simulation, every method's fit, a suite row and record files; store all in $(TIMES)"
	@echo "make diagnosis-reports   diagnose the measured HSVA runs anew and write reports/diagnosis (needs the data)"
	@echo "make indices-report   make models from indices of published and measured ships, write reports/indices (needs the data)"
	@echo "make exam-report  make an exam of EXAM_WORLDS=12 worlds, answer and score it, write reports/exam (ten minutes)"
	@echo "make reports  run the suites of the published leaderboard into out/, write reports/leaderboard"
	@echo "make advice   test the leaderboard's advice in 60 fresh situations, write reports/leaderboard/advice.md"
	@echo "make board-pages  write README and page of reports/leaderboard anew from its tables"
	@echo "make hashes   write requirements/hashes.txt anew, the digests of the pinned files; make audit: look for known vulnerabilities"
	@echo "make asset    pack the pages and tables of reports/ that are not in the repository into dist/, for a release"
	@echo "make packages  build wheel and sdist into dist/, install and use them with every Python of 3.11 to 3.14 found here"
	@echo "make sizes    MB and seconds of the base and of each extra in a clean environment, for the installation page"
	@echo "make image    build the container of the Dockerfile and run the README's two commands in it"
	@echo "make format   format the code; make lint | types: one check alone; make clean: remove what was built"

env: $(STAMP)

# uv installs in a quarter of pip's time, but does not read pip's settings (a mirror, say): then pip does it.
PACKAGES := --quiet --constraint requirements/constraints.txt
INSTALL = install() { $(BIN)/uv pip install --python $(BIN)/python --no-cache $(PACKAGES) "$$@" 2>/dev/null \
	|| $(BIN)/python -m pip install $(PACKAGES) "$$@"; }; install

# shipmmg, which the tests compare with, wants a Pillow of 2024: it is installed without what it wants.
$(STAMP): pyproject.toml requirements/constraints.txt
	@test -n "$(PYTHON)" || { echo "helmbench needs Python 3.11 or newer with venv (Debian: apt-get install python3-venv)" >&2; exit 1; }
	@test ! -e $(STAMP) || test "$$(cat $(STAMP))" = "$$(pwd -P)" || rm -rf .venv
	@rm -f $(STAMP)
	@echo "Installing helmbench and what it needs into .venv"
	$(PYTHON) -m venv .venv
	@$(BIN)/python -m pip install $(PACKAGES) uv
	@$(INSTALL) setuptools wheel
	@$(INSTALL) --no-build-isolation --editable '.[dev]'
	@$(INSTALL) --no-deps "shipmmg; python_version < '3.14'"
	@pwd -P > $(STAMP)

# Status 1 of `run` means that some runs failed: the report lists them, and the status stays.
bench: env
	@rm -rf $(RESULTS)
	@status=0; $(BIN)/helmbench run --suite quick -o $(RESULTS) || status=$$?; \
	test $$status -gt 1 || $(BIN)/helmbench report $(RESULTS) || status=$$?; \
	exit $$status

# The README's picture of the leaderboard.
board-picture: bench
	$(BIN)/python -m helmbench.reporting.leaderboard.board $(RESULTS) reports/leaderboard/quick.svg

# The published pages are replaced only when everything has been computed.
reproduce: env
	rm -rf $(REPRODUCTION)
	$(BIN)/helmbench reproduce -o $(REPRODUCTION)
	rm -rf reports/reproduction
	mkdir -p reports
	cp -R $(REPRODUCTION)/pages reports/reproduction

reproduction-pages: env
	$(BIN)/python -m helmbench.reproduction.pages.markdown reports/reproduction

# Compares with the runs of `make reproduce`.
verdicts: env
	rm -rf $(REPRODUCTION)-again
	$(BIN)/helmbench reproduce --seed 1 -o $(REPRODUCTION)-again --quiet
	$(BIN)/python -m helmbench.reproduction.stability $(REPRODUCTION) $(REPRODUCTION)-again

# $(call debian,COMMAND,PACKAGES): install Debian packages where a command is not there.
debian = @command -v $(1) >/dev/null || { as=$$(test "$$(id -u)" -eq 0 || echo sudo); \
  $$as apt-get update -qq && $$as env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $(2); }

# The tests look at pages in Debian's Chromium.
browser:
	$(call debian,chromium,chromium)

# The tests compile exported functional mock-up units.
compiler:
	$(call debian,cc,gcc libc6-dev)

# In a new environment the first collection compiles what the tests import: once, not once by each worker.
TEST = mkdir -p build; test build/collected.log -nt $(STAMP) || $(BIN)/pytest --collect-only -qq > build/collected.log; \
	MAKEFLAGS= MAKELEVEL= $(BIN)/pytest -n $(WORKERS) --dist worksteal $(1)

test: lint browser compiler
	@$(MAKE) --no-print-directory --jobs 2 types every-behaviour

every-behaviour: env
	@$(call TEST,-m "not nightly")

# Every seed is shifted by a number that is drawn and printed; the rates are drawn a few times each.
test-all: export HELMBENCH_SEED := $(DRAWN_SEED)
test-all: lint types browser compiler
	@$(call TEST,tests tests/nightly)

lint: env
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

# A copy of the sources, laid out as they install: see [tool.ty] in pyproject.toml.
types: env
	@rm -rf build/types
	@mkdir -p build/types
	@cp -rL helmbench build/types
	@cp -rL $(ROOMS) build/types/helmbench
	@$(BIN)/ty check

format: env
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

page-picture: env browser
	$(BIN)/python docs/page_picture.py docs/_static/page.png

# Where .venv holds the extra `docs` alone, that is enough.
docs: $(if $(wildcard $(BIN)/sphinx-build),$(wildcard $(STAMP)),env)
	$(BIN)/python -m sphinx -q -W --keep-going docs docs/_build
	@echo "docs/_build/index.html"

# The suite draws its seed anew and prints it; more rounds are more cases.
rates: export HELMBENCH_SEED := $(DRAWN_SEED)
rates: env
	HELMBENCH_RATE_DRAWS=20 $(BIN)/pytest tests/nightly/rates -n $(WORKERS) -rP
	rm -rf $(RATES)
	$(BIN)/helmbench run --suite imperfect --seeds $(RATE_ROUNDS) -o $(RATES)
	$(BIN)/helmbench report $(RATES)

fuzz: env
	FUZZ_SECONDS=$(FUZZ_SECONDS) $(BIN)/python -m tests.helmbench.fuzz.run

wrong-data: env
	$(BIN)/python -m tests.helmbench.wrong_data.run

ugly: export HELMBENCH_SEED := $(DRAWN_SEED)
ugly: env
	$(BIN)/pytest tests/nightly/robustness -n $(WORKERS) -rP

# Rows that are there for the same code are not measured again, so an interrupted `make timing` goes on.
# Some peers are large and needed by nothing else; without one its rows say that it is missing.
timing: env
	@for peer in casadi diffrax polars; do $(INSTALL) $$peer || echo "$$peer cannot be installed: its rows are left out"; done
	@mkdir -p $(dir $(ROWS))
	$(BIN)/pytest tests/timing/test_peers.py tests/timing/test_ratios.py tests/timing/test_growth.py --rows $(ROWS) || test $$? -eq 5
	$(BIN)/python -m helmbench.reporting.timing $(ROWS) reports/timing

fit-times: env
	@mkdir -p $(dir $(TIMES))
	$(BIN)/pytest tests/timing/test_timing.py --benchmark-json=$(TIMES)

hashes: $(TOOLS)/installed
	$(TOOLS)/bin/uv pip compile requirements/constraints.txt --quiet --generate-hashes --no-deps --no-annotate --no-header \
		--python-version 3.11.7 --output-file requirements/hashes.txt

audit: $(TOOLS)/installed
	@$(TOOLS)/bin/python .ci/audit.py $(TOOLS)/bin/pip-audit requirements/hashes.txt

$(TOOLS)/installed:
	$(PYTHON) -m venv $(TOOLS)
	$(TOOLS)/bin/python -m pip install --quiet --constraint requirements/constraints.txt uv pip-audit==2.10.1
	@touch $@

# From what git tracks: what lies about in the checkout goes into no package.
dist: env
	rm -rf dist build/source
	mkdir -p build/source
	git archive HEAD | tar -x -C build/source
	$(BIN)/python -m build --no-isolation --outdir dist build/source > build/packages.log

# Attached to a release: the pages and tables of reports/ that the repository does not hold.
asset:
	@ls $(BOARD:%=reports/leaderboard/%) > /dev/null || { echo "make reports first, or unpack the archive of a release" >&2; exit 2; }
	mkdir -p dist
	tar -czf dist/helmbench-reports-$$(sed -n 's/^version = "\(.*\)"/\1/p' pyproject.toml).tar.gz $(BOARD:%=reports/leaderboard/%)

packages: dist
	$(BIN)/python .ci/packages.py try dist

sizes: dist
	$(BIN)/python .ci/packages.py sizes dist docs/how-to/install-sizes.txt

image:
	docker build --tag helmbench .
	docker run --rm helmbench

diagnosis-reports: env
	$(BIN)/python -m helmbench.reporting.diagnosis.measured reports/diagnosis

indices-report: env
	$(BIN)/python -m helmbench.reporting.indices reports/indices

# A small exam, answered by the diagnosers of the package and by two naive ones.
exam-report: env
	rm -rf out/exam && mkdir -p out/exam
	$(BIN)/helmbench exam make out/exam/worlds --key out/exam/key.json --worlds $(EXAM_WORLDS) --seed $(EXAM_SEED)
	for name in $(ENTRANTS); do $(BIN)/helmbench exam answer out/exam/worlds --diagnoser $$name -o out/exam/$$name \
	  || test $$? -eq 1 || exit 2; done
	$(BIN)/helmbench exam score out/exam/worlds $(addprefix out/exam/,$(ENTRANTS)) --key out/exam/key.json -o out/exam/scores
	cp out/exam/scores/scores.md reports/exam/README.md

# Suites that are finished are not run again; status 1 of `run` means that some runs failed, which is a result.
reports: env
	@for suite in $(SUITES) minutes; do \
	  $(BIN)/helmbench run --suite $$suite -o out/$$suite --resume || test $$? -eq 1 || exit 2; done
	$(BIN)/python -m helmbench.reporting.leaderboard.publish out/minutes reports/leaderboard/minutes
	$(BIN)/python -m helmbench.reporting.leaderboard.publish $(addprefix out/,$(SUITES)) reports/leaderboard

# Goes on where it stopped; then README says what the advice is worth.
advice: env
	$(BIN)/helmbench advice reports/leaderboard -o out/advice
	cp out/advice/advice.md reports/leaderboard/advice.md
	$(BIN)/python -m helmbench.reporting.leaderboard.publish reports/leaderboard

# From the tables that lie there: no suite is run.
board-pages: env
	$(BIN)/python -m helmbench.reporting.leaderboard.publish reports/leaderboard/minutes
	$(BIN)/python -m helmbench.reporting.leaderboard.publish reports/leaderboard

clean:
	rm -rf .venv build dist out docs/_build docs/jupyter_execute docs/generated *.egg-info .pytest_cache .ruff_cache .hypothesis .benchmarks
	find $(ROOMS) helmbench tests -name __pycache__ -type d -prune -exec rm -rf {} +
