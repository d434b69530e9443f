from hypothesis import given, settings
from hypothesis import strategies as st

from scenarios.dataset.columns import Columns

VALUES = st.none() | st.booleans() | st.integers(0, 9) | st.floats(0, 1) | st.text(max_size=3) | st.just([])
ROWS = st.lists(st.dictionaries(st.sampled_from("abc"), VALUES), min_size=1, max_size=6)


@settings(max_examples=50, deadline=None)
@given(ROWS, st.integers(0, 6))
def test_every_key_has_one_type_beside_null_and_related_pairs_have_none_of_it(rows, related):
    rows = [{"related": k < related, **row} for k, row in enumerate(rows)]
    columns = Columns()
    for row in rows:
        columns.note(row)
    fitted = [columns.fitted(row) for row in rows]

    assert len({tuple(row) for row in fitted}) == 1
    for key in fitted[0]:
        types = {type(row[key]) for row in fitted if row[key] is not None}
        assert len(types) <= 1
        assert not types or related == 0 or None not in [row[key] for row in fitted if row["related"]]


@given(ROWS)
def test_what_all_rows_tell_alike_is_kept(rows):
    full = [{"related": True, "a": float(k), "b": "text", **{"c": k}} for k, _ in enumerate(rows)]
    columns = Columns()
    for row in full:
        columns.note(row)

    assert [columns.fitted(row) for row in full] == full
