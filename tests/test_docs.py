import re
from pathlib import Path

import pytest

import rectmerge as rm
from scenarios.suites.suite import load_suite

ROOT = Path(__file__).parents[1]
PAGES = sorted((ROOT / "docs").glob("*.md"))
SIMULATION = (ROOT / "docs" / "simulation.md").read_text(encoding="utf-8")


def test_the_snippets_of_suite_files_make_a_suite(tmp_path):
    world, mission, maps = re.findall(r"```toml\n(.*?)```", SIMULATION, re.DOTALL)
    path = tmp_path / "mine.toml"
    path.write_text(f'title = "Mine"\n[[scenarios]]\nname = "mine"\n{world}{maps}{mission}')

    (scenario,) = load_suite(path).scenarios

    assert (scenario.world.family, scenario.mission.overlap, scenario.b.poses) == ("hospital", 0.4, "slam")
    assert scenario.mission.b.lidar.beams == 360


def test_the_example_of_corruptions_runs(monkeypatch):
    (example,) = re.findall(r"```python\n(.*?)```", SIMULATION, re.DOTALL)
    monkeypatch.chdir(ROOT)
    names: dict[str, object] = {}

    exec(example, names)

    assert len(names["points"]) == 1


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page):
    for target in re.findall(r"\]\(([^)#]+)\)", page.read_text(encoding="utf-8")):
        assert target.startswith("http") or (page.parent / target).exists(), target


def test_the_page_of_the_library_holds_every_public_name():
    page = (ROOT / "docs" / "api.md").read_text(encoding="utf-8")
    shown = re.findall(r"^::: rectmerge\.(\S+)$", page, re.MULTILINE)

    missing = [name for name, home in rm._HOME.items() if home not in shown and f"{home}.{name}" not in shown]
    assert not missing
