import ast
import dataclasses
import math
from pathlib import Path

import pytest

import rectmerge.robust
from rectmerge.errors import InputError, MethodError
from rectmerge.methods import make_method
from rectmerge.robust.params import Params

GROUPS = {field.name: getattr(Params(), field.name) for field in dataclasses.fields(Params)}
GROUPS = {name: group for name, group in GROUPS.items() if dataclasses.is_dataclass(group)}
FIELDS = [(name, field) for name, group in GROUPS.items() for field in dataclasses.fields(group)]
FIELDS += [("", field) for field in dataclasses.fields(Params) if field.name not in GROUPS]
MODULES = [path for path in Path(rectmerge.robust.__file__).parent.glob("*.py") if path.name != "params.py"]
# numbers of codes, units and encodings: another value gives the same answer, or none
STRUCTURAL = {
    "branch_and_bound.py": {"COMPLEX"},
    "correlation.py": {"QUARTER_TURNS"},
    "face_score.py": {
        "STEPS_PER_NAT", "POOLED_CELLS", "PADDING", "LEVELS", "ZERO", "UNBOUNDED", "_NOTHING",
    },
    "features.py": {"QUARTER_TURN_DEG", "ROUNDED_CELLS"},
    "likelihood.py": {"STEPS_PER_NAT"},
    "verdict.py": {"NO_AGREEMENT"},
    "wall_agreement.py": {"CODES", "LONG", "CLUTTER", "KINDS"},
}  # fmt: skip


@pytest.mark.parametrize(("group", "field"), FIELDS, ids=[f"{group}.{field.name}" for group, field in FIELDS])
def test_every_parameter_has_a_unit_and_a_source(group, field):
    assert field.metadata.get("unit"), f"{group}.{field.name}"
    assert field.metadata.get("source"), f"{group}.{field.name}"


@pytest.mark.parametrize("path", MODULES, ids=lambda path: path.name)
def test_no_module_but_params_has_a_number_that_tunes(path):
    assert numeric_constants(ast.parse(path.read_text())) <= STRUCTURAL.get(path.name, set())


def numeric_constants(module: ast.Module) -> set[str]:
    """Return the names that a module binds to a value with a number in it."""
    names = set()
    for statement in module.body:
        if isinstance(statement, ast.Assign):
            targets, value = statement.targets, statement.value
        elif isinstance(statement, ast.AnnAssign) and statement.value is not None:
            targets, value = [statement.target], statement.value
        else:
            continue
        if any(isinstance(node, ast.Constant) and type(node.value) in (int, float) for node in ast.walk(value)):
            names |= {node.id for target in targets for node in ast.walk(target) if isinstance(node, ast.Name)}
    return names


@pytest.mark.parametrize("text", ["LIMIT = 3", "LIMIT: float = 0.5", "A, LIMIT = (1, 2)", "LIMIT = np.array([1.0])"])
def test_a_number_that_tunes_would_be_seen(text):
    assert "LIMIT" in numeric_constants(ast.parse(text))


@pytest.mark.parametrize(("name", "group"), GROUPS.items())
def test_a_number_that_is_none_is_refused_with_its_name(name, group):
    for field in dataclasses.fields(group):
        value = getattr(group, field.name)
        if isinstance(value, float):
            with pytest.raises(InputError, match=field.name):
                dataclasses.replace(group, **{field.name: math.nan})


def test_a_count_below_one_and_a_length_of_nothing_are_refused():
    with pytest.raises(InputError, match="max_refined must be >= 1, got 0"):
        dataclasses.replace(Params().propose, max_refined=0)
    with pytest.raises(InputError, match="block_cells must be finite and > 0, got 0"):
        dataclasses.replace(Params().rank, block_cells=0.0)


@pytest.mark.parametrize(
    ("name", "value", "says"),
    [
        ("robust.confidence.rigid", "1,2", "11 values"),
        ("robust.confidence.bent", "1", "7 values"),
        ("robust.rank.spreads_cells", "1,2", "3 values"),
        ("robust.exact.strides", "1,1", "9 values"),
        ("robust.rank.outliers", "0.05,0.15,2", "at most 1"),
        ("robust.verdict.accept_at", "7", "at most 1"),
        ("robust.rank.near_cells", "1", "matched_cells < near_cells < contradicted_cells"),
        ("robust.rank.contradicted_cells", "4", "matched_cells < near_cells < contradicted_cells"),
        ("robust.prepare.margin_cells", "100000", "at most 1000"),
        ("robust.prepare.diagonal_cells", "1e9", "at most 4000"),
        ("robust.prepare.fine_bin_cells", "1e-12", ">= 0.01"),
        ("robust.propose.max_hypotheses", "1000000000000", "at most 10000000"),
        ("robust.correlate.scale_step", "1e-9", ">= 0.001"),
        ("robust.rank.bend_cells", "100000", "at most 200"),
        ("robust.max_candidates", "many", "a whole number"),
        ("robust.prepare.free_share", "all", "a number"),
    ],
)
def test_a_value_that_cannot_be_is_refused_by_name(name, value, says):
    field = name.removeprefix("robust.")

    with pytest.raises(MethodError, match=says) as error:
        make_method("robust", **{field: value})
    assert field.rpartition(".")[2] in str(error.value)
