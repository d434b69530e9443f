"""Marks of the paper's equations and algorithm lines in the sources, against the table of the room."""

import functools
import io
import re
import tokenize
from collections import defaultdict
from pathlib import Path

import pytest

import rectmerge.paper

PACKAGE = Path(rectmerge.paper.__file__).parents[1]
MARK = re.compile(r"eq\. \((\d+)\)|Alg\. (\d), lines? (\d+)(?:-(\d+))?")
LIKE_A_MARK = re.compile(r"\b(eq|alg|equation|algorithm)\b", re.IGNORECASE)
LAST_LINES = {1: 24, 2: 7, 3: 24, 4: 17, 5: 18}  # before "end procedure"
CLOSING = {1: {22, 23, 24}, 2: set(), 3: {19, 20, 21}, 4: set(), 5: {17}}  # lines that only end a block


@functools.cache
def comments():
    """List every comment of the package with its module."""
    return [
        (f"rectmerge/{path.relative_to(PACKAGE).as_posix()}", token.string)
        for path in sorted(PACKAGE.rglob("*.py"))
        for token in tokenize.generate_tokens(io.StringIO(path.read_text(encoding="utf-8")).readline)
        if token.type == tokenize.COMMENT
    ]


def marks():
    """Collect the modules and the lines of every mark."""
    modules, lines = defaultdict(set), defaultdict(set)
    for module, comment in comments():
        for equation, algorithm, first, last in MARK.findall(comment):
            key = f"eq. ({equation})" if equation else f"Alg. {algorithm}"
            modules[key].add(module)
            if algorithm:
                lines[int(algorithm)] |= set(range(int(first), int(last or first) + 1))
    return modules, lines


def table():
    """Read the table of the room: mark to modules."""
    claimed, key = {}, ""
    for line in (rectmerge.paper.__doc__ or "").splitlines():
        if match := re.match(r"(eq\. \(\d+\)|Alg\. \d)", line):
            claimed[key := match[1]] = set()
        if key:
            claimed[key] |= set(re.findall(r"rectmerge/[\w/]+\.py", line))
    return claimed


def test_the_table_names_every_equation_and_algorithm():
    assert set(table()) == {f"eq. ({n})" for n in range(1, 14)} | {f"Alg. {n}" for n in range(1, 6)}


@pytest.mark.parametrize("mark", [f"eq. ({n})" for n in range(1, 14)] + [f"Alg. {n}" for n in range(1, 6)])
def test_every_mark_is_in_the_modules_of_the_table_and_in_no_other(mark):
    assert marks()[0][mark] == table()[mark]


@pytest.mark.parametrize("algorithm", range(1, 6))
def test_every_line_of_an_algorithm_is_marked(algorithm):
    missing = set(range(2, LAST_LINES[algorithm] + 1)) - marks()[1][algorithm] - CLOSING[algorithm]

    assert not missing


def test_marks_have_one_form():
    odd = [(module, comment) for module, comment in comments() if LIKE_A_MARK.search(MARK.sub("", comment))]

    assert odd == []
