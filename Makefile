# make shell   the main job: install, then build the prototype shell as one STEP file
# make test    install, then run every test
# make bench   speed, size and memory beside the alternatives, as ratios
# make docs    the documentation as a site, build/docs/index.html
# make pictures  draw the pictures of the documentation anew
# Another interpreter: make shell PYTHON=python3.12

PYTHON  ?= python3
OUT     ?= exports
WORKERS ?= 3

VENV := .venv
BIN  := $(VENV)/bin
PIP  := $(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt

.PHONY: shell test lint bench docs pictures clean distclean

shell: $(VENV)/.installed
	$(BIN)/ifs-cad build parts/shell_prototype.py -o $(OUT)/

test: $(VENV)/.installed-for-development
	$(BIN)/python -m pytest -n $(WORKERS) --dist worksteal

lint: $(VENV)/.installed-for-development
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

bench: $(VENV)/.installed-for-development
	$(BIN)/python benchmarks/run.py

docs: $(VENV)/.installed-for-development
	$(BIN)/python -m sphinx -q -W --keep-going -b html docs build/docs
	@echo "Open build/docs/index.html"

pictures: $(VENV)/.installed-for-development
	$(BIN)/python docs/make_pictures.py

clean:
	find exports -mindepth 1 ! -name .gitkeep -delete
	find . -name __pycache__ -not -path './$(VENV)/*' -prune -exec rm -rf {} +
	rm -rf build dist .hypothesis .mypy_cache .pytest_cache .ruff_cache

distclean: clean
	rm -rf $(VENV)

# The stamps are touched last: what was interrupted is done again.
$(VENV)/.installed: $(VENV)/.created pyproject.toml constraints.txt
	@echo "Installing ifs_cad and the CAD kernel into $(VENV): half a gigabyte, a few minutes."
	@$(PIP) --editable .
	@touch $@

$(VENV)/.installed-for-development: $(VENV)/.created pyproject.toml constraints.txt
	@echo "Installing ifs_cad, the CAD kernel and the test tools into $(VENV): a few minutes."
	@$(PIP) --editable '.[view,mesh,fabrication,nesting,structure,studio,docs,test,dev]'
	@touch $@

$(VENV)/.created:
	@command -v $(PYTHON) >/dev/null || { \
	  echo "$(PYTHON) was not found. ifs_cad needs Python 3.11 or newer; if yours has another" \
	       "name: make PYTHON=python3.12 ..." >&2; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { \
	  echo "ifs_cad needs Python 3.11 or newer and $(PYTHON) is" \
	       "$$($(PYTHON) --version 2>&1): make PYTHON=python3.12 ... names another one." >&2; \
	  exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || { \
	  echo "$(PYTHON) cannot make virtual environments." \
	       "On Debian or Ubuntu: apt-get install python3-venv" >&2; exit 1; }
	@$(PYTHON) -m venv --clear $(VENV)
	@touch $@
