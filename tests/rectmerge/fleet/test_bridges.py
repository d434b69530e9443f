import itertools

from hypothesis import given
from hypothesis import strategies as st

from rectmerge.fleet.bridges import find_bridges

edge_lists = st.sets(st.sampled_from(list(itertools.combinations(range(7), 2))))


def parts(edges):
    groups = {node: {node} for node in range(7)}
    for a, b in edges:
        if groups[a] is not groups[b]:
            groups[a] |= groups[b]
            for node in groups[b]:
                groups[node] = groups[a]
    return len({id(group) for group in groups.values()})


@given(edge_lists)
def test_bridges_are_the_edges_without_which_a_graph_has_more_parts(edges):
    by_trial = {edge for edge in edges if parts(edges - {edge}) > parts(edges)}

    assert find_bridges(sorted(edges)) == by_trial
