import json
import math

import pytest

from rectmerge.errors import InputError
from rectmerge.similarity import Similarity
from rectmerge.transfer.points import carry_points

TURNED = Similarity(2.0, math.pi / 2, 10.0, 0.0)  # (x, y) goes to (10 - 2 y, 2 x)
PLACE = {"type": "Point", "coordinates": [1, 2]}


def carried(document, b_to_a=TURNED):
    return json.loads(carry_points(json.dumps(document), "zones.geojson", b_to_a))


def test_csv_keeps_its_other_columns():
    text = "name,y,x\ndoor,2.0,1.0\n\nlift,0,0\n"

    assert carry_points(text, "way.csv", TURNED) == "name,y,x\ndoor,2.000000,6.000000\nlift,0.000000,10.000000\n"
    assert carry_points("1.0,2.0\n", "w.csv", Similarity(tx=1.0)) == "2.000000,2.000000\n"


@pytest.mark.parametrize("text", ["x;note;y\n1;a,b;2\n", "x\tnote\ty\n1\ta,b\t2\n"])
def test_a_csv_is_written_by_the_separator_that_its_header_line_has(text):
    expected = text.replace("1", "6.000000").replace("2", "2.000000")

    assert carry_points(text, "way.csv", TURNED) == expected


def test_comments_stay_as_they_are_and_where_they_are():
    text = '# by hand, "so\nx,y,note\n#1,2\n1,2,"two\n# lines"\n# end'

    output = carry_points(text, "way.csv", TURNED)

    assert output == '# by hand, "so\nx,y,note\n#1,2\n6.000000,2.000000,"two\n# lines"\n# end'


UNNAMED = "name the columns x and y in a header line, by commas, semicolons or tabs; line"


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("5,1,2\n6,3,4\n", "1: '5,1,2'"),
        ("1,2\n3,4,5\n", "2: '3,4,5'"),
        ("# x y yaw\n1,2,3\n", "2: '1,2,3'"),
        ("1\n", "1: '1'"),
        ("1;2\n", "1: '1;2'"),
        ("1\t2\n", r"1: '1\\t2'"),
        ("pose_x,pose_y\n1,2\n", "1: 'pose_x,pose_y'"),
        ("name,x\nlift,2\n", "1: 'name,x'"),
    ],
)
def test_columns_are_not_guessed(text, shown):
    with pytest.raises(InputError, match=f"^p.csv: not CSV with columns x and y: {UNNAMED} {shown}$"):
        carry_points(text, "p.csv", TURNED)


@pytest.mark.parametrize(
    ("name", "before", "after"),
    [
        ("yaw", "0.5", math.pi / 2 + 0.5),
        (" Theta ", "-0.5", math.pi / 2 - 0.5),
        ("HEADING", "3", 3 - 1.5 * math.pi),
        ("yaw", f"{math.pi / 2}", math.pi),
        ("yaw_deg", "100", -170),
        ("heading_deg", "90", 180),
        ("theta_deg", "-450", 0),
    ],
)
def test_a_heading_is_turned_with_its_point_and_lies_within_half_a_turn(name, before, after):
    table = carry_points(f"x,{name},y\n1,{before},2\n", "way.csv", TURNED)
    feature = carried({"type": "Feature", "geometry": PLACE, "properties": {name: float(before), "id": 7}})

    heads, cells = table.splitlines()
    assert heads == f"x,{name},y"
    assert float(cells.split(",")[1]) == pytest.approx(after, abs=1e-7)
    assert feature["properties"] == {name: pytest.approx(after, abs=1e-7), "id": 7}


@pytest.mark.parametrize("before", ["q", "orientation.", "Orientation_"])
def test_a_quaternion_is_turned_with_its_point(before):
    yaw = 0.3
    text = f"x,y,{before}z,{before}w\n1,2,{math.sin(yaw / 2)},{math.cos(yaw / 2)}\n"

    *_, z, w = map(float, carry_points(text, "way.csv", TURNED).splitlines()[1].split(","))

    assert 2 * math.atan2(z, w) == pytest.approx(math.pi / 2 + yaw, abs=1e-7)


def test_a_tilted_quaternion_turns_about_the_vertical_and_keeps_its_tilt():
    up = (0.1, -0.2, 0.3, 0.927362)  # x, y, z, w
    names = ["qx", "qy", "qz", "qw"]

    feature = carried({"type": "Feature", "geometry": PLACE, "properties": dict(zip(names, up, strict=True))})

    s = c = math.sqrt(0.5)  # of half the turn
    x, y, z, w = up
    expected = [c * x - s * y, c * y + s * x, c * z + s * w, c * w - s * z]
    assert [feature["properties"][name] for name in names] == pytest.approx(expected, abs=1e-8)


def test_an_empty_heading_stays_empty():
    assert carry_points("x,y,yaw,qz,qw\n1,2,,,\n", "w.csv", TURNED).endswith("\n6.000000,2.000000,,,\n")
    assert carried({"type": "Feature", "geometry": PLACE, "properties": {"yaw": None}})["properties"] == {"yaw": None}


@pytest.mark.parametrize(
    ("heads", "cells", "message"),
    [
        ("yaw", "90", "yaw: 90 is more than a turn in radians; name it yaw_deg if in degrees"),
        ("yaw", "north", "yaw: 'north' is not a finite number"),
        ("yaw_deg", "inf", "yaw_deg: 'inf' is not a finite number"),
        ("qz", "0.1", "qz and qw belong together"),
        ("qx,qz,qw", "0,0,1", "qx and qy belong together"),
        ("qx,qy", "0,0", "qx and qy are no heading without qz and qw"),
        ("qz,qw", "0,0", "qx, qy, qz, qw: a quaternion of zeros is no heading"),
    ],
)
def test_a_heading_that_cannot_be_turned_is_refused(heads, cells, message):
    with pytest.raises(InputError, match=f"^way.csv: not CSV .*: line 3: {message}"):
        carry_points(f"x,y,{heads}\n# one\n1,2,{cells}\n", "way.csv", TURNED)


@pytest.mark.parametrize("name", ["x", "y", "yaw", "qz"])
def test_a_name_that_stands_twice_is_refused(name):
    with pytest.raises(InputError, match=f"line 1: two columns are named {name}"):
        carry_points(f"x,y,yaw,qz,qw, {name.upper()}\n1,2,0,0,1,0\n", "way.csv", TURNED)
    with pytest.raises(InputError, match="yaw is given twice"):
        carried({"type": "Feature", "geometry": PLACE, "properties": {"yaw": 1, "Yaw": 2}})


def test_a_warning_names_what_looks_like_a_heading_and_stays(caplog):
    line = {"type": "LineString", "coordinates": [[0, 0], [1, 1]]}
    features = [
        {"type": "Feature", "geometry": PLACE, "properties": {"yaw": 0, "name": "lift"}},
        {"type": "Feature", "geometry": line, "properties": {"Yaw": 0, "orientation": 1, "heading": None}},
        {"type": "Feature", "geometry": None, "properties": None},
    ]

    carried({"type": "FeatureCollection", "features": features})
    carry_points("x,y,Angle,name\n1,2,0,lift\n", "way.csv", TURNED)

    stays = [message.split(" stays")[0] for message in caplog.messages]
    assert stays == ["property orientation", "property Yaw", "column angle"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "the file is empty"),
        ("\n \n", "the file is empty"),
        ("x,y\n", "not CSV with columns x and y: it holds no points"),
        ("x,y\n1,2\n\n3\n", "not CSV .*: line 4 has too few columns: '3'"),
        ("# none\n", "not CSV with columns x and y: it holds no points"),
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

    collection = carried({"type": "FeatureCollection", "features": [{"type": "Feature", "geometry": both}]})

    zone, place = collection["features"][0]["geometry"]["geometries"]
    assert zone["coordinates"] == [[[10, 0], [10, 2], [8, 2, 7], [10, 0]]]
    assert place["coordinates"] == [6, 2]


def test_only_geometry_is_carried():
    lift = {"properties": {"coordinates": [1, 2], "geometry": PLACE}, "coordinates": [1, 2], "id": 7}

    feature = carried({"type": "Feature", "geometry": PLACE} | lift)

    assert feature == {"type": "Feature", "geometry": {"type": "Point", "coordinates": [6, 2]}} | lift


def test_a_box_is_drawn_anew_around_what_was_carried():
    line = {"type": "LineString", "coordinates": [[0, 0, 5], [3, 1, 4]], "bbox": [0, 0, 4, 3, 1, 5]}
    features = [{"type": "Feature", "geometry": geometry, "bbox": [0, 0, 3, 1]} for geometry in (line, PLACE)]

    collection = carried({"type": "FeatureCollection", "features": features, "bbox": [0, 0, 3, 2]})

    assert collection["bbox"] == [6, 0, 10, 6]
    assert [feature["bbox"] for feature in collection["features"]] == [[8, 0, 4, 10, 6, 5], [6, 2, 6, 2]]
    assert collection["features"][0]["geometry"]["bbox"] == [8, 0, 4, 10, 6, 5]


@pytest.mark.parametrize(
    "document",
    [
        {"type": "FeatureCollection", "features": []},
        {"type": "Feature", "geometry": None, "properties": {}},
        {"type": "GeometryCollection", "geometries": []},
        {"type": "LineString", "coordinates": []},
        {"type": "Polygon", "coordinates": [[]]},
    ],
)
def test_what_is_legally_empty_stays_as_it_is(document):
    assert carried(document) == document
    assert carried(document | {"bbox": [0, 0, 1, 1]}) == document  # of nothing there is no box


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
