import csv
import io
import json
import math
import shutil

import numpy as np
import pytest

from rectmerge.elastic.transform import BentTransform
from rectmerge.io.map_file import read_map
from rectmerge.transfer.points import carry_points
from tests.rectmerge.cli.answers import rectmerge
from tests.rectmerge.elastic.merges import merge_bent_maps
from tests.rectmerge.elastic.test_unbend import bent_case


@pytest.fixture(scope="module")
def merged(tmp_path_factory):
    """The folder of a merge of maps that bend."""
    return merge_bent_maps(tmp_path_factory.mktemp("bent"))


@pytest.fixture
def bend(merged):
    return BentTransform.from_dict(json.loads((merged / "unbend.json").read_text()))


def test_points_and_headings_are_carried_by_the_bend(merged, bend, tmp_path, capsys):
    b = read_map(merged / "b.yaml")
    places = b.pixel_to_map(bent_case(2)[2][::100])
    rows = "".join(f"{x},{y},0.5\n" for x, y in places)
    (tmp_path / "way.csv").write_text("x,y,yaw\n" + rows)

    assert rectmerge("transform", merged, "--points", tmp_path / "way.csv") == 0

    carried = list(csv.DictReader(io.StringIO(capsys.readouterr().out)))
    assert list(carried[0]) == ["x", "y", "yaw", "bend_std"]
    found = np.array([[float(row["x"]), float(row["y"])] for row in carried])
    assert np.abs(found - bend.apply(places)).max() < 1e-5
    turned = np.array([float(row["yaw"]) for row in carried]) - 0.5 - bend.local_angle(places)
    assert np.abs(np.angle(np.exp(1j * turned))).max() < 1e-6
    assert np.ptp(bend.local_angle(places)) > 0.01  # each its own
    assert np.abs([float(row["bend_std"]) for row in carried] - bend.std(places)).max() < 1e-5


def test_a_point_outside_the_bend_has_no_standard_deviation_and_is_told(merged, tmp_path, capsys):
    (tmp_path / "way.csv").write_text("x,y\n500,500\n5,5\n")

    assert rectmerge("transform", merged, "--points", tmp_path / "way.csv") == 0

    shown = capsys.readouterr()
    assert [row.split(",")[2] == "" for row in shown.out.splitlines()[1:]] == [True, False]
    assert "1 points lie outside the bend" in shown.err


def test_a_trajectory_is_carried_by_the_bend_into_a_file(merged, bend, tmp_path):
    (tmp_path / "b.tum").write_text("0.5 12 9 0 0 0 0 1\n")

    assert rectmerge("transform", merged, "--trajectory", tmp_path / "b.tum", "-o", tmp_path / "a.tum") == 0

    row = list(map(float, (tmp_path / "a.tum").read_text().split()))
    assert row[1:3] == pytest.approx(bend.apply([12.0, 9.0]).tolist(), abs=1e-5)


def test_at_a_point_the_transform_is_that_of_the_bend(merged, bend, capsys):
    assert rectmerge("transform", merged, "--as", "pose", "--at", "12,9") == 0

    x, y, yaw = map(float, capsys.readouterr().out.split())
    turn = np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])
    assert np.abs(turn @ [12.0, 9.0] + [x, y] - bend.apply([12.0, 9.0])).max() < 1e-5
    assert yaw == pytest.approx(float(bend.local_angle([12.0, 9.0])), abs=1e-7)


def test_without_a_point_the_bend_is_noted(merged, capsys):
    assert rectmerge("transform", merged) == 0

    shown = capsys.readouterr()
    assert "map B was bent by up to" in shown.err
    assert "--at X,Y gives the one that is right" in shown.err


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--at", "1"], "'1' is not x,y: a point of map B"),
        (["--at", "1,nan"], "'1,nan' is not x,y"),
        (["--at", "1,2", "--points", "p.csv"], "--at and --points exclude each other"),
        (["--points", "p.csv", "--trajectory", "t.tum"], "--points and --trajectory exclude each other"),
    ],
)
def test_bad_use_is_one_line(merged, capsys, words, message):
    assert rectmerge("transform", merged, *words) == 2

    assert message in capsys.readouterr().err


def shifted(text):
    content = json.loads(text)
    content["b_to_a"]["translation"][0] += 5.0
    return json.dumps(content)


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda path: path.unlink(), "unbend.json: cannot be read"),
        (lambda path: path.write_text("{}"), "unbend.json: not an answer of rectmerge merge: there is no 'schema'"),
        (lambda path: path.write_text("[1]"), "unbend.json: not an answer of rectmerge merge"),
        (lambda path: path.write_text(path.read_text().replace('"scale": ', '"scale": 1')), "it is of another merge"),
        (lambda path: path.write_text(shifted(path.read_text())), "it is of another merge"),
    ],
)
def test_a_damaged_bend_is_named(merged, tmp_path, capsys, damage, message):
    for name in ("alignment.json", "unbend.json"):
        shutil.copy(merged / name, tmp_path)
    damage(tmp_path / "unbend.json")

    assert rectmerge("transform", tmp_path, "--as", "matrix") == 2

    assert message in capsys.readouterr().err


def test_geojson_gets_the_standard_deviation_of_its_points(bend):
    point = {"type": "Feature", "geometry": {"type": "Point", "coordinates": [12.0, 9.0]}, "properties": {"yaw": 0.0}}

    feature = json.loads(carry_points(json.dumps(point), "zones.geojson", bend))

    assert feature["geometry"]["coordinates"] == pytest.approx(bend.apply([12.0, 9.0]).tolist())
    assert feature["properties"]["bend_std"] == pytest.approx(float(bend.std([12.0, 9.0])))
    assert feature["properties"]["yaw"] == pytest.approx(float(bend.local_angle([12.0, 9.0])))


def test_waypoints_turn_by_the_turn_at_their_place(bend):
    text = "waypoints:\n  one:\n    pose: [12.0, 9.0, 0.0]\n    orientation: [1.0, 0.0, 0.0, 0.0]\n"

    carried = carry_points(text, "way.yaml", bend)

    half = float(bend.local_angle([12.0, 9.0])) / 2
    assert f"{math.sin(half):.6f}"[:8] in carried


@pytest.mark.parametrize("place", ["[NaN, 1]", "[1e999, 1]", "[1, -Infinity]"])
def test_places_that_are_no_numbers_are_refused(bend, place):
    with pytest.raises(ValueError, match="not a finite number"):
        carry_points(f'{{"type": "Point", "coordinates": {place}}}', "p.json", bend)


def test_a_csv_without_header_keeps_its_two_columns(bend):
    assert len(carry_points("12,9\n", "p.csv", bend).strip().split(",")) == 2
