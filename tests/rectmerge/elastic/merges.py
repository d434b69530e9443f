"""A merge of two maps that bend against each other, by the command."""

from pathlib import Path

from rectmerge.grid import OccupancyGrid
from rectmerge.io.map_file import write_map
from tests.rectmerge.cli.answers import rectmerge
from tests.rectmerge.elastic.test_unbend import bent_case


def write_bent_maps(folder: Path) -> tuple[Path, Path, str]:
    """Write two maps that bend against each other; return their files and the option that places B."""
    a, b, _, _, fit = bent_case(2)
    write_map(OccupancyGrid(a.occupancy, 0.05, (-3.0, 2.0, 0.4)), folder / "a.yaml")
    write_map(OccupancyGrid(b.occupancy, 0.04, (1.0, -1.0, 0.0)), folder / "b.yaml")
    (c, s, tx), (_, _, ty) = fit.matrix.tolist()
    return folder / "a.yaml", folder / "b.yaml", f"--pixels={c},{-s},{tx},{ty}"


def merge_bent_maps(folder: Path) -> Path:
    """Merge such maps into the folder that holds them."""
    assert rectmerge("merge", *write_bent_maps(folder), "-o", folder) == 0
    return folder
