import json
import shutil

from rectmerge.cli import console
from scenarios.cli import main as cli
from tests import drawing


def test_accepted_pairs_are_certified_or_said_to_be_open(tmp_path, capsys):
    maps = tmp_path / "test" / "maps"
    maps.mkdir(parents=True)
    for name in ("a", "b"):
        for suffix in (".yaml", ".pgm"):
            shutil.copy(drawing.DATA / f"building_{name}{suffix}", maps)
    row = {
        "pair_id": "building",
        "map_a_file_name": "maps/building_a.yaml",
        "map_b_file_name": "maps/building_b.yaml",
        "related": True,
        "pixels": drawing.B_IN_A.matrix.tolist(),
        "control_points": [
            [*drawing.B_IN_A.apply([u, v]).tolist(), u, v] for u, v in ((0.0, 0.0), (90.0, 0.0), (0.0, 90.0))
        ],
        "residual_px": 0.0,
    }
    (tmp_path / "test" / "metadata.jsonl").write_text(json.dumps(row) + "\n")

    assert console.run(cli.app, "rectbench", ["certify", str(tmp_path), "--seconds", "60", "--quiet"]) == 0

    said = capsys.readouterr().out
    assert "building  " in said
    assert "of 1 accepted pairs: 1 certified, 0 rivalled, 0 left open" in said
