import json
import math

import pytest

from rectmerge.errors import InputError
from rectmerge.points import carry_points
from rectmerge.similarity import Similarity

TURNED = Similarity(2.0, math.pi / 2, 10.0, 0.0)  # (x, y) goes to (10 - 2 y, 2 x)
PLACE = {"type": "Point", "coordinates": [1, 2]}


def carried(told, b_to_a=TURNED):
    return json.loads(carry_points(json.dumps(told), "zones.geojson", b_to_a))


def test_csv_keeps_its_other_columns():
    text = "name,y,x\ndoor,2.0,1.0\n\nlift,0,0\n"

    assert carry_points(text, "way.csv", TURNED) == "name,y,x\ndoor,2.000000,6.000000\nlift,0.000000,10.000000\n"
    assert carry_points("1.0,2.0,a\n", "w.csv", Similarity(tx=1.0)) == "2.000000,2.000000,a\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "the file is empty"),
        ("\n \n", "the file is empty"),
        ("x,y\n", "not CSV with columns x and y: it holds no points"),
        ("x,y\n1,2\n\n3\n", "not CSV .*: line 4 has too few columns: '3'"),
        ("1\n", "not CSV .*: line 1 has too few columns: '1'"),
        ("name,x\nlift,2\n", "not CSV .*: line 1: 'name' is not a finite number"),
        ('x,y,"a\nb"\n1,2,3\n1,two,3\n', "not CSV .*: line 4: 'two' is not a finite number"),
        ("x,y\nnan,1\n", "not CSV .*: line 2: 'nan' is not a finite number"),
        ("x,y\n1e308,1e308\n", "not CSV .*: a coordinate is not a finite number, or too large"),
    ],
)
def test_a_csv_without_points_is_refused_by_its_line(text, message):
    with pytest.raises(InputError, match=f"^p.csv: {message}"):
        carry_points(text, "p.csv", TURNED)


def test_geojson_is_carried_however_deep_its_coordinates_are():
    zone = {"type": "Polygon", "coordinates": [[[0, 0], [1, 0], [1, 1, 7], [0, 0]]]}
    both = {"type": "GeometryCollection", "geometries": [zone, PLACE]}

    found = carried({"type": "FeatureCollection", "features": [{"type": "Feature", "geometry": both}]})

    zone, place = found["features"][0]["geometry"]["geometries"]
    assert zone["coordinates"] == [[[10, 0], [10, 2], [8, 2, 7], [10, 0]]]
    assert place["coordinates"] == [6, 2]


def test_only_geometry_is_carried():
    lift = {"properties": {"coordinates": [1, 2], "geometry": PLACE}, "coordinates": [1, 2], "id": 7}

    found = carried({"type": "Feature", "geometry": PLACE} | lift)

    assert found == {"type": "Feature", "geometry": {"type": "Point", "coordinates": [6, 2]}} | lift


def test_a_box_is_drawn_anew_around_what_was_carried():
    line = {"type": "LineString", "coordinates": [[0, 0, 5], [3, 1, 4]], "bbox": [0, 0, 4, 3, 1, 5]}
    features = [{"type": "Feature", "geometry": one, "bbox": [0, 0, 3, 1]} for one in (line, PLACE)]

    found = carried({"type": "FeatureCollection", "features": features, "bbox": [0, 0, 3, 2]})

    assert found["bbox"] == [6, 0, 10, 6]
    assert [one["bbox"] for one in found["features"]] == [[8, 0, 4, 10, 6, 5], [6, 2, 6, 2]]
    assert found["features"][0]["geometry"]["bbox"] == [8, 0, 4, 10, 6, 5]


@pytest.mark.parametrize(
    "told",
    [
        {"type": "FeatureCollection", "features": []},
        {"type": "Feature", "geometry": None, "properties": {}},
        {"type": "GeometryCollection", "geometries": []},
        {"type": "LineString", "coordinates": []},
        {"type": "Polygon", "coordinates": [[]]},
    ],
)
def test_what_is_legally_empty_stays_as_it_is(told):
    assert carried(told) == told
    assert carried(told | {"bbox": [0, 0, 1, 1]}) == told  # of nothing there is no box


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (" ", "the file is empty"),
        ("{", "not GeoJSON: "),
        ("[]", r"not GeoJSON: an object must stand where there is \[\]"),
        ('{"coordinates": [1, 2]}', "not GeoJSON: there is no type None"),
        ('{"type": "Topology"}', "not GeoJSON: there is no type 'Topology'"),
        ('{"type": "Point"}', "not GeoJSON: a Point has no coordinates"),
        ('{"type": "FeatureCollection", "features": {}}', "not GeoJSON: features must be a list"),
        ('{"type": "Point", "coordinates": 3}', "not GeoJSON: coordinates must be lists of numbers, got 3"),
        ('{"type": "Point", "coordinates": ["1", 1]}', "not GeoJSON: a position must be two numbers or more"),
        ('{"type": "Point", "coordinates": [1]}', "not GeoJSON: a position must be two numbers or more"),
        ('{"type": "Point", "coordinates": [1, NaN]}', "not GeoJSON: a coordinate is not a finite number"),
        ('{"type": "Point", "coordinates": [1, 1%s]}' % ("0" * 400), "not GeoJSON: int too large"),
        ('{"type": "GeometryCollection", "geometries": ' * 9999, "not GeoJSON: "),
    ],
)
def test_what_is_no_geojson_is_refused_by_name(text, message):
    with pytest.raises(InputError, match=f"^p.geojson: {message}"):
        carry_points(text, "p.geojson", TURNED)
