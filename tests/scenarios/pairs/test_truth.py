import math
from dataclasses import replace

import numpy as np
import pytest

from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from scenarios.pairs.map_view import MapSpec, place_map
from scenarios.pairs.truth import _any_of, control_point_rmse, control_points, is_bent, is_on_wall, known_extent
from sim.world import Prism
from tests.scenarios.known_answers import pixel_to_world
from tests.sim.small_worlds import box_world, office_log, wall_distance

LOG = office_log()


def square(x: float, y: float, top: float = 1.0) -> Prism:
    """A post of 0.4 x 0.4 m."""
    return Prism(np.array([[x, y], [x + 0.4, y], [x + 0.4, y + 0.4], [x, y + 0.4]]), top)


def test_surface_is_what_both_visits_find_in_the_plane_of_the_laser():
    world = replace(
        box_world(),
        furniture=(square(1.0, 1.0), square(2.0, 1.0, top=0.2)),
        glass=(square(3.0, 1.0),),
        visits=((square(4.0, 1.0),), (square(5.0, 1.0),)),
    )
    beside = np.array([[1.0, 1.2], [2.0, 1.2], [3.0, 1.2], [4.0, 1.2], [5.0, 1.2], [0.25, 2.0], [0.35, 2.0]])

    assert is_on_wall(world, beside, 0.25).tolist() == [True, False, False, False, False, True, False]


def test_surface_reaches_a_tenth_of_a_metre_from_the_walls():
    world = replace(LOG.world, glass=(), visits=((), ()))
    points = np.random.default_rng(0).uniform(0, 10, (3000, 2))
    away = wall_distance(world, points)
    inside = np.any([prism.covers(points) for prism in world.walls + world.furniture], axis=0)
    is_surface = is_on_wall(world, points, 0.25)

    assert is_surface[(away < 0.0999) | inside].all()
    assert not is_surface[(away > 0.1415) & ~inside].any()  # corners are mitred


def test_what_both_robots_hit_where_the_world_has_nothing_is_not_chosen():
    maps = [
        place_map(robot, LOG.spec.a.lidar, MapSpec(), noise=0, seed=np.random.SeedSequence(k))
        for k, robot in enumerate((LOG.a, LOG.b))
    ]
    longest = max(LOG.world.walls, key=lambda wall: np.ptp(wall.outline, axis=0).max())
    less = replace(LOG.world, walls=tuple(wall for wall in LOG.world.walls if wall is not longest))
    nothing = replace(LOG.world, walls=(), furniture=())
    chosen = [
        control_points(replace(LOG, world=world), *maps, np.random.default_rng(0))
        for world in (LOG.world, less, nothing)
    ]

    away = [wall_distance(less, pixel_to_world(maps[0], points[:, :2])) for points in chosen[:2]]
    assert away[0].max() > 0.5
    assert away[1].max() < 0.15
    assert chosen[2] is None


def test_any_of_draws_from_all_the_places_of_a_key():
    keys = np.array([7, 3, 7, 5, 3, 7])
    drawn = np.array([_any_of(np.array([3, 7]), keys, np.random.default_rng(seed)) for seed in range(200)])

    assert set(drawn[:, 0]) == {1, 4}
    assert set(drawn[:, 1]) == {0, 2, 5}
    assert np.bincount(drawn[:, 1])[[0, 2, 5]].min() > 40


def test_error_of_hand_computed_points():
    # B's points are kept in place by the identity; A has them 3 and 4 cells away: sqrt((9 + 16) / 2)
    points = np.array([[3.0, 0.0, 0.0, 0.0], [10.0, 4.0, 10.0, 0.0]])

    assert control_point_rmse(np.eye(2, 3), points) == pytest.approx(math.sqrt(12.5))


def test_extent_is_the_diagonal_of_the_known_cells_only():
    cells = np.full((50, 50), -1, np.int8)
    cells[10, 5] = 0
    cells[12, 8] = 100  # box of 3 rows and 4 columns

    assert known_extent(OccupancyGrid(cells)) == 5.0


def test_a_map_without_known_cells_cannot_be_scored():
    with pytest.raises(InputError, match="no known cell"):
        known_extent(OccupancyGrid(np.full((5, 5), -1, np.int8)))


def test_bent_begins_above_one_and_a_half_percent():
    assert [is_bent(r) for r in (None, 0.0, 0.015, 0.0151)] == [False, False, False, True]
