import pytest

from rectmerge.live.params import LiveParams
from rectmerge.live.track import Track
from rectmerge.similarity import Similarity
from tests.rectmerge.live.growing import A, B

HERE, NEAR, FAR = (Similarity(1.0, 0.5, x, 2.0) for x in (1.0, 1.04, 4.0))  # 0.8 and 60 cells apart
PARAMS = LiveParams()


def take(track, *answers, remembered=None):
    """What each answer changes: a placement and the version of B it rests on, or a version alone for a refusal."""
    changes = []
    for answer in answers:
        if isinstance(answer, int):
            changes.append(track.refuse({"b": answer}, PARAMS))
        else:
            placement, version = answer
            result = track.accept(placement, {"a": 1, "b": version}, (A, B), PARAMS, remembered)
            changes.append(result and result[0])
    return changes


@pytest.mark.parametrize(
    ("answers", "changes"),
    [
        ([(HERE, 1), (NEAR, 2)], [None, "joined"]),
        ([(HERE, 1), (HERE, 1)], [None, None]),  # the same maps say nothing new
        ([(HERE, 1), (FAR, 2), (FAR, 3)], [None, None, "joined"]),
        ([(HERE, 1), 2, (HERE, 3), (HERE, 4)], [None, None, None, "joined"]),
    ],
    ids=["two agree", "one map twice", "two disagree", "refused between"],
)
def test_a_placement_is_published_after_answers_in_a_row_that_agree(answers, changes):
    track = Track()

    assert take(track, *answers) == changes
    assert (track.published is not None) == (changes[-1] == "joined")


def test_a_published_placement_moves_a_little_at_once_and_far_only_after_answers_that_agree():
    track = Track()
    take(track, (HERE, 1), (HERE, 2))

    assert take(track, (NEAR, 3)) == [None]
    assert track.published == NEAR
    assert take(track, (FAR, 4)) == [None]
    assert track.published == NEAR
    assert take(track, (FAR, 5)) == ["moved"]
    assert track.published == FAR


def test_a_published_placement_is_taken_out_after_refusals_of_different_maps():
    track = Track()
    take(track, (HERE, 1), (HERE, 2))

    assert take(track, 3, 3) == [None, None]
    assert track.published == HERE
    assert take(track, (NEAR, 4), 5, 6) == [None, None, "taken out"]
    assert track.published is None


def test_an_answer_that_is_not_sure_confirms_and_does_nothing_else():
    track = Track()
    unsure = {"params": PARAMS, "confidence": 0.94}
    for version in (1, 2, 3):
        assert track.accept(HERE, {"b": version}, (A, B), **unsure) is None
    assert track.published is None
    take(track, (HERE, 4), (HERE, 5))
    assert track.accept(NEAR, {"b": 6}, (A, B), **unsure) is None
    assert track.published == NEAR
    assert track.accept(FAR, {"b": 7}, (A, B), **unsure) is None
    assert track.published == NEAR


def test_the_more_questions_were_asked_the_surer_the_last_answer_must_be():
    track = Track()
    answer = {"params": PARAMS, "confidence": 0.98}
    assert track.accept(HERE, {"b": 1}, (A, B), question=1, **answer) is None
    assert track.accept(HERE, {"b": 2}, (A, B), question=2, **answer) is None  # two that agree, but 0.9917 is asked
    surer = {"params": PARAMS, "confidence": 0.997}
    assert track.accept(HERE, {"b": 3}, (A, B), question=3, **surer) == ("joined", 0.0)


def test_the_risk_of_all_questions_is_no_more_than_that_of_one():
    shares = [1.0 - PARAMS.confidence_asked(question) for question in range(1, 10_001)]

    assert sum(shares) == pytest.approx(1.0 - PARAMS.least_confidence, rel=1e-3)
    assert sum(shares) < 1.0 - PARAMS.least_confidence
    assert shares == sorted(shares, reverse=True)


def test_each_question_has_a_number_of_its_own_whichever_map_has_changed():
    track = Track()
    versions = [(1, 1, 1), (1, 1, 1), (1, 1, 2), (1, 1, 3), (2, 1, 3), (2, 2, 4), (5, 3, 4)]
    numbers = [track.ask({"a": a, "b": b, "c": c}, a + b - 1) for a, b, c in versions]

    assert numbers == [1, 1, 2, 3, 4, 5, 7]  # each different question a larger one, so no share is given twice


def test_of_two_robots_the_number_is_that_of_the_pairs_that_their_maps_have_been():
    track = Track()
    for a, b in ((1, 1), (1, 2), (2, 3), (2, 3), (5, 3)):
        assert track.ask({"a": a, "b": b}, a + b - 1) == a + b - 1


def test_a_remembered_placement_counts_as_one_answer_where_it_agrees():
    assert take(Track(), (NEAR, 1), remembered=HERE) == ["joined"]
    assert take(Track(), (FAR, 1), remembered=HERE) == [None]
