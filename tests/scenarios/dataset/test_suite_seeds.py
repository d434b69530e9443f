import hashlib
import json
import pickle

import pytest

from rectmerge.errors import InputError
from scenarios.dataset.generate import generate, plan
from scenarios.dataset.suite_seeds import Secret, mixed
from scenarios.suites.spec import Seeds
from scenarios.suites.suite import load_suite
from tests.scenarios.dataset.folders import contents
from tests.scenarios.tiny_suite import TinySuite

SECRET, OTHER = Secret("00112233445566778899aabbccddeeff"), Secret("f" * 32)
SUITE = TinySuite(seeds=Seeds(count=2))
pytestmark = pytest.mark.usefixtures("no_picture")


def make(folder, secret=None):
    info = generate(SUITE, folder, secret=secret)
    return info, {name: data for name, data in contents(folder).items() if "/" in name}


def test_the_same_secret_makes_the_same_bytes_and_another_one_other_maps(tmp_path):
    (info, first), (_, again), (_, other), (_, open_to_all) = (
        make(tmp_path / str(k), secret) for k, secret in enumerate((SECRET, SECRET, OTHER, None))
    )

    assert first == again
    assert first.keys() == other.keys() == open_to_all.keys()
    maps = [name for name in first if name.endswith("_a.png")]
    assert len(maps) == 4
    assert all(len({made[name] for made in (first, other, open_to_all)}) == 3 for name in maps)
    assert info["secret_sha256"] == hashlib.sha256(bytes.fromhex(SECRET.digits)).hexdigest()


def test_the_secret_itself_is_written_nowhere(tmp_path):
    make(tmp_path / "set", SECRET)

    assert not any(SECRET.digits.encode() in data for data in contents(tmp_path / "set").values())
    assert SECRET.digits not in repr([SECRET, mixed(SUITE, SECRET)])


def test_an_unfinished_data_set_of_another_secret_is_refused(tmp_path, monkeypatch):
    with monkeypatch.context() as patch:
        patch.setattr("scenarios.dataset.writer.picture", lambda folder: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            make(tmp_path / "set", SECRET)

    with pytest.raises(InputError, match="differs in secret_sha256"):
        make(tmp_path / "set", OTHER)


def test_a_finished_data_set_of_a_secret_is_not_the_open_one(tmp_path):
    hidden, _ = make(tmp_path / "hidden", SECRET)
    plain, _ = make(tmp_path / "open")

    assert make(tmp_path / "hidden", SECRET)[0] == hidden
    assert make(tmp_path / "open")[0] == plain
    for folder, secret in (("hidden", None), ("hidden", OTHER), ("open", SECRET)):
        with pytest.raises(InputError, match="holds a finished data set; --force replaces it"):
            make(tmp_path / folder, secret)


def test_open_data_sets_of_before_there_were_secrets_are_gone_on_with(tmp_path, monkeypatch):
    info_file, journal = tmp_path / "set/dataset_info.json", tmp_path / "set/unfinished.jsonl"
    with monkeypatch.context() as patch:
        patch.setattr("scenarios.dataset.writer.picture", lambda folder: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            make(tmp_path / "set")
    journal.write_text(journal.read_text().replace('"secret_sha256": null, ', "", 1))
    assert '"secret_sha256"' not in journal.read_text()
    make(tmp_path / "set")
    assert "--secret" not in (tmp_path / "set/README.md").read_text()

    info = json.loads(info_file.read_text())
    del info["secret_sha256"]
    info_file.write_text(json.dumps(info))
    assert make(tmp_path / "set")[0] == info
    with pytest.raises(InputError, match="holds a finished data set"):
        make(tmp_path / "set", SECRET)


def test_every_seed_of_a_suite_is_mixed_values_left_open_included():
    suite = load_suite("standard")
    sources, secrets, others = (
        [job.source for job in plan(made, pairs=12)] for made in (suite, mixed(suite, SECRET), mixed(suite, OTHER))
    )

    for purpose in ("world", "mission", "pair"):
        seeds = [source._seed(purpose) for source in (*sources, *secrets, *others)]
        assert len(set(seeds)) == len(seeds)
        assert max(source._seed(purpose) for source in secrets) > 2**32  # too wide to be tried out
    assert [source.source_id for source in secrets] == [source.source_id for source in sources]
    assert {source.suite for source in secrets} == {f"standard-{SECRET.sha256[:8]}"}
    assert [source.scenario.world for source in secrets] != [source.scenario.world for source in sources]
    assert pickle.loads(pickle.dumps(secrets[0])) == secrets[0]


def test_a_fleet_is_mixed_too():
    suites = load_suite("fleet-3"), mixed(load_suite("fleet-3"), SECRET)
    first, hidden = (next(iter(plan(suite, pairs=1))).source for suite in suites)

    assert first.source_id == hidden.source_id
    assert first._seed("home") != hidden._seed("home")


BAD = {
    "none": (None, "cannot be read"),
    "nothing": ("", "an even number of hexadecimal digits"),
    "words": ("correct horse battery staple\n", "an even number of hexadecimal digits"),
    "short": ("0123456789abcdef\n", "needs 32 hexadecimal digits, got 16"),
    "half a byte": ("0" * 33, "an even number of hexadecimal digits"),
    "two lines": (f"{'0' * 32}\n{'1' * 32}\n", "an even number of hexadecimal digits"),
    "bytes": ("\xff\x00" * 40, "an even number of hexadecimal digits"),
}


@pytest.mark.parametrize(("text", "message"), BAD.values(), ids=BAD)
def test_what_is_no_secret_is_refused_with_the_file_and_the_remedy(tmp_path, text, message):
    path = tmp_path / "secret.txt"
    if text is not None:
        path.write_text(text, encoding="latin-1")

    with pytest.raises(InputError, match=message) as refused:
        Secret.from_file(path)
    assert str(refused.value).startswith(str(path))
    assert text is None or "openssl rand -hex 16 > secret.txt" in str(refused.value)


def test_blanks_and_capitals_do_not_count(tmp_path):
    (tmp_path / "secret.txt").write_text(f"\n {SECRET.digits.upper()} \n")

    assert Secret.from_file(tmp_path / "secret.txt") == SECRET
