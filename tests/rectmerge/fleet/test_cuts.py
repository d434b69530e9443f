from rectmerge.fleet.cuts import reached, weak_cuts


def test_weak_cuts_are_single_maps_and_the_sides_of_bridges_without_the_reference():
    edges = [(0, 1), (0, 2), (1, 2), (2, 3), (3, 4), (3, 5), (4, 5)]  # two triangles and a bridge

    assert weak_cuts(range(6), edges, 0) == [(1,), (1, 2, 3, 4, 5), (2,), (3,), (3, 4, 5), (4,), (5,)]
    assert (0, 1, 2) in weak_cuts(range(6), edges, 5)
    assert weak_cuts((0, 1), [(0, 1)], 0) == [(1,)]


def test_maps_are_reached_by_chains_of_pairs():
    assert reached({0}, [(1, 2), (0, 1), (3, 4)]) == {0, 1, 2}
    assert reached({5}, [(1, 2)]) == {5}
