PY := .venv/bin/python

.PHONY: demo test coverage lint format clean
demo: .venv/ready ; .venv/bin/kinopix demo --out demo --overwrite
test: .venv/ready ; $(PY) -m pytest -n 2
coverage: .venv/ready ; $(PY) -m pytest -n 2 --cov --cov-report=term --cov-fail-under=90
lint: .venv/ready ; $(PY) -m ruff check . && $(PY) -m ruff format --check . && .venv/bin/lint-imports && $(PY) -m mypy && $(PY) -m pyright
format: .venv/ready ; $(PY) -m ruff check --fix . ; $(PY) -m ruff format .
clean: ; rm -rf .venv demo build dist *.egg-info

.venv/ready: pyproject.toml constraints.txt
	python3 -m venv .venv
	$(PY) -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[dev]'
	$(PY) -c 'import instrument'  # compiles its loops, once
	touch $@
