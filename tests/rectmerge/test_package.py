import importlib
import subprocess
import sys
from pathlib import Path

import pytest

import rectmerge


@pytest.mark.parametrize("name", rectmerge.__all__)
def test_every_public_name_is_there_whatever_was_imported_before(name):
    for module in Path(rectmerge.__file__).parent.glob("[a-z]*.py"):
        importlib.import_module(f"rectmerge.{module.stem}")  # a module named as a function would hide it

    assert getattr(rectmerge, name).__name__ == name


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no_such_name"):
        rectmerge.no_such_name  # noqa: B018 - the look-up is what is tested


def test_importing_the_package_imports_nothing_heavy():
    code = "import sys, rectmerge; assert not {'numpy', 'cv2', 'numba', 'typer'} & set(sys.modules)"

    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_the_ten_lines_of_the_documentation_run(tmp_path):
    from rectmerge import align, compose, read_map, write_map
    from tests import drawing

    a = read_map(drawing.DATA / "building_a.yaml")
    alignment = align(a, a)

    assert alignment, alignment.reason
    write_map(compose([a, a], [None, alignment.b_to_a]).grid, tmp_path / "merged.yaml")
    assert (read_map(tmp_path / "merged.yaml").occupancy == a.occupancy).all()
