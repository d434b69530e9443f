import json

from rectmerge import methods
from tests.rectmerge.cli.answers import rectmerge


def test_methods_lists_what_can_be_named_and_set(capsys):
    assert rectmerge("methods") == 0
    text = capsys.readouterr().out
    assert rectmerge("methods", "--json") == 0

    assert f"{methods.DEFAULT_METHOD} (default)" in text
    assert "--set paper.delta_cells=" in text
    assert "--set robust.rank.spreads_cells=1.0,2.0,4.0" in text
    assert set(json.loads(capsys.readouterr().out)["methods"]) == set(methods.available())
