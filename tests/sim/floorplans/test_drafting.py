import numpy as np
import pytest

from rectmerge.errors import SimulationError
from sim.floorplans.drafting import Gap, Pen
from sim.floorplans.shapes import rectangle
from sim.world import covers


def pen(*, wall=0.2, door=(0.8, 1.2), glass=0.0):
    return Pen(np.random.default_rng(0), size_m=(10.0, 8.0), wall_m=(wall, wall), door_m=door, glass=glass)


def is_covered(prisms, points):
    return np.any([covers(prism.outline, points) for prism in prisms], axis=0)


def test_the_shell_is_closed_fills_the_size_and_reaches_into_the_rooms():
    drawn = pen()
    drawn.shell(rectangle(*drawn.box()))
    corners = np.concatenate([prism.outline for prism in drawn.walls])
    points = np.random.default_rng(1).uniform(0.0, (10.0, 8.0), (4000, 2))
    depth = np.minimum(points, np.array([10.0, 8.0]) - points).min(axis=1)

    assert np.allclose([corners.min(axis=0), corners.max(axis=0)], [[0.0, 0.0], [10.0, 8.0]])
    assert np.array_equal(is_covered(drawn.walls, points), depth <= drawn.outer_m)
    assert drawn.inner_m == pytest.approx(0.2)
    assert 0.2 <= drawn.outer_m <= 0.4


def test_a_shell_with_an_inward_corner_is_closed():
    drawn = pen()
    outline = np.array([[1.0, 1.0], [8.0, 1.0], [8.0, 4.0], [4.0, 4.0], [4.0, 7.0], [1.0, 7.0]])
    drawn.shell(outline)
    ways = np.linspace(0.0, 1.0, 200)[:, None]
    line = np.concatenate([p + (q - p) * ways for p, q in zip(outline, np.roll(outline, -1, axis=0), strict=True)])

    assert is_covered(drawn.walls, line).all()


@pytest.mark.parametrize("line", [[(1, 1), (7, 1)], [(1, 1), (5, 7)], [(1, 1), (4, 1), (6, 3), (6, 6)]])
def test_a_wall_stands_everywhere_but_in_its_gaps(line):
    drawn, points = pen(), np.array(line, dtype=float)
    drawn.wall(points, [Gap(3.5, 4.5, "a", "b"), Gap(1.0, 2.0, "a", "b", is_door=False)])
    ways = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    at = np.linspace(0.0, ways[-1], 500)
    middle = np.stack([np.interp(at, ways, points[:, k]) for k in (0, 1)], axis=-1)
    open_here = ((at > 3.5) & (at < 4.5)) | ((at > 1.0) & (at < 2.0))

    assert np.array_equal(is_covered(drawn.walls, middle), ~open_here)
    assert [door.joins for door in drawn.doors] == [("a", "b")]
    assert len(drawn.openings) == 1


def test_bends_of_a_wall_are_closed_on_the_outside():
    drawn = pen()
    drawn.wall([(1.0, 1.0), (4.0, 1.0), (4.0, 5.0)])

    assert is_covered(drawn.walls, np.array([[4.099, 0.901]])).all()
    assert not is_covered(drawn.walls, np.array([[4.11, 0.901], [4.099, 0.89]])).any()


def test_doors_are_within_their_wall_and_their_widths():
    drawn = pen(door=(0.8, 1.2))
    gaps = [drawn.door(1.0, 3.0, "a", "b")[0] for _ in range(100)]
    widths = [gap.end - gap.start for gap in gaps]

    assert min(gap.start for gap in gaps) >= 1.25 - 1e-9
    assert max(gap.end for gap in gaps) <= 2.75 + 1e-9
    assert 0.8 <= min(widths) < 0.85
    assert 1.15 < max(widths) <= 1.2


def test_a_door_that_does_not_fit_is_left_out_or_refused():
    assert pen().door(0.0, 1.2, "a", "b", is_needed=False) == []
    with pytest.raises(SimulationError, match=r"a door of 0.8 m does not fit into 1.20 m of wall"):
        pen().door(0.0, 1.2, "a", "b")


def test_a_glass_partition_is_glass_from_end_to_end():
    drawn = pen(glass=1.0)
    drawn.shell(rectangle(*drawn.box()))
    drawn.wall([(1.0, 1.0), (7.0, 1.0)], [Gap(2.0, 3.0, "a", "b")])

    assert len(drawn.walls) == 4
    assert len(drawn.glass) == 2
