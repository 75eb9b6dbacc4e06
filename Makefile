PY := .venv/bin/python

SITE := NUMBA_DISABLE_JIT=1 $(PY) -m sphinx --quiet --fresh-env --fail-on-warning --keep-going --conf-dir docs --doctree-dir build/doctrees
PACKAGES := pip install --quiet --no-compile --constraint constraints.txt --editable '.[dev]'

.PHONY: demo test thorough coverage lint mypy pyright format docs docs-links clean
test thorough coverage: export PYTHONDONTWRITEBYTECODE =  # a module is compiled once, not in each of the many processes of the tests
demo: .venv/compiled ; .venv/bin/kinopix demo --out demo --overwrite
test: .venv/compiled ; $(PY) -m pytest -n 2 --dist worksteal
thorough: .venv/compiled ; $(PY) -m pytest -n 2 --dist worksteal -m 'thorough or not thorough'
coverage: .venv/compiled ; $(PY) -m pytest -n 2 --dist worksteal --cov --cov-report=term --cov-fail-under=90
lint: .venv/ready
	$(PY) -m ruff check .
	$(PY) -m ruff format --check .
	.venv/bin/lint-imports
	+$(MAKE) --no-print-directory -j 2 mypy pyright
mypy pyright: .venv/ready ; $(PY) -m $@
format: .venv/ready ; $(PY) -m ruff check --fix . ; $(PY) -m ruff format .
docs: .venv/ready ; $(SITE) . build/site  # pages and headings that links lead to are checked; begin at build/site/index.html
docs-links: .venv/ready ; $(SITE) --builder linkcheck . build/links  # links to other sites: needs the net
clean: ; rm -rf .venv demo build dist *.egg-info

# uv takes a third of pip's time, but knows nothing of pip's settings: where it does not reach the packages, pip may.
.venv/ready: pyproject.toml constraints.txt
	python3 -m venv .venv
	$(PY) -m pip install --quiet --disable-pip-version-check --constraint constraints.txt uv && $(PY) -m uv $(PACKAGES) || $(PY) -m $(PACKAGES)
	$(PY) -m compileall -q -j 0 -x '/(tests?|pip|mypy|networkx)/' .venv/lib || true  # not what is never imported
	touch $@

# The compiled loops, once: lint and docs do not wait for them.
.venv/compiled: .venv/ready ; $(PY) -c 'import instrument.analysis, instrument.live' && touch $@
