# What contributors and .ci/run do. Variables: FILE of `test-of`, MKDOCS of `site`.
.PHONY: setup test test-of slow lint site
export NO_MKDOCS_2_WARNING := 1

setup: # a virtual environment's packages, and the checks before each commit
	pip install -e '.[test]'
	pre-commit install

test: # all but the slow tests
	pytest

test-of: # tests of FILE="src/...", several by spaces; without it, of what differs from the last commit
	@tests=$$(python -m tests.affected $(FILE)) && echo "$$tests" && pytest $$tests

slow: # the tests that take more than a few seconds, in the files that have any
	pytest -m slow $$(grep -rlw --include='test_*.py' slow tests)

lint: # style, types and directions of imports
	ruff check .
	ruff format --check .
	mypy
	lint-imports

site: # the folder site, with pip install -e '.[docs]'; a broken link fails, which --quiet would hide
	mkdocs build --strict $(MKDOCS)
