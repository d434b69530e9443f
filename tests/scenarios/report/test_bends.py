from scenarios.report.bends import bend_cells
from tests.scenarios.scoring.test_bends import row


def test_a_method_has_a_line_where_a_map_was_bent():
    lines = bend_cells({"some": [row(), row(accepted=False)], "refused": [row(accepted=False)], "none": []})

    assert lines == [
        ("some", ["2", "1", "10.00", "5.00", "1", "0", "50%", "10%"]),
        ("refused", ["1", "0", "-", "-", "0", "0", "-", "-"]),
    ]


def test_there_is_no_table_where_nothing_was_bent():
    assert bend_cells({"some": [row(accepted=False)]}) == []
