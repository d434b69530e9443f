from dataclasses import dataclass, make_dataclass
from pathlib import Path

import numpy as np
import pytest

from scenarios.dataset.content_hash import content_hash
from scenarios.dataset.generate import identity_of
from scenarios.suites.suite import load_suite


@dataclass(frozen=True)
class Part:
    size: float = 1.0


class Method:
    name = "mine"

    def __init__(self, radius=2):
        self.radius = radius


def test_the_name_of_a_class_does_not_count_but_its_fields_do():
    renamed = make_dataclass("Renamed", [("size", float, 1.0)])

    assert content_hash(Part()) == content_hash(renamed())
    assert content_hash(Part()) != content_hash(Part(2.0))


def test_methods_that_are_no_dataclasses_count_by_name_and_attributes():
    other = type("Other", (Method,), {"name": "theirs"})

    assert content_hash(Method()) == content_hash(Method(2))
    assert len({content_hash(method) for method in (Method(), Method(3), other())}) == 3


@pytest.mark.parametrize(
    "changed", [np.ones((2, 3)), np.zeros((3, 2)), np.zeros((2, 3), np.float32), [np.zeros((2, 3))]]
)
def test_arrays_count_by_shape_type_and_values(changed):
    assert content_hash(np.zeros((2, 3))) == content_hash(np.zeros((3, 2)).T)
    assert content_hash(np.zeros((2, 3))) != content_hash(changed)


def test_paths_do_not_count():
    assert content_hash({"at": Path("here"), "n": 1}) == content_hash({"at": Path("there"), "n": 1})


def test_data_sets_of_two_suites_differ_and_of_one_suite_do_not():
    first, again, other = (identity_of(load_suite(name), pairs=2, seed=0) for name in ("smoke", "smoke", "trust"))

    assert first == again
    assert first["suite_sha256"] != other["suite_sha256"]
