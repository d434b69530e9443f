from dataclasses import dataclass
from typing import Annotated

import pytest
import typer

import rectmerge.cli.main
import scenarios.cli.main
from rectmerge.cli import console
from rectmerge.cli.app import App

APPS = {"rectmerge": rectmerge.cli.main.app, "rectbench": scenarios.cli.main.app}
SUBCOMMANDS = [(prog, name) for prog, app in APPS.items() for name in typer.main.get_command(app).commands]


@dataclass(frozen=True, kw_only=True)
class Colours:
    wall: Annotated[str, typer.Option("--wall", help="Colour of walls.")] = "black"
    floor: Annotated[str | None, typer.Option(help="Colour of the floor.")] = None


def painted(words):
    calls = []
    app = App("Paint.")

    @app.command()
    def paint(room: str, colours: Colours, twice: bool = False) -> None:
        calls.append((room, colours, twice))

    @app.command()
    def wash() -> None: ...

    return console.run(app, "tool", ["paint", *words]), calls


@pytest.mark.parametrize(("prog", "name"), SUBCOMMANDS)
@pytest.mark.parametrize("option", ["--quiet", "-q", "--debug"])
@pytest.mark.parametrize("before", [True, False])
def test_every_subcommand_takes_the_common_options_before_and_after_its_name(capsys, prog, name, option, before):
    words = [option, name] if before else [name, option]

    assert console.run(APPS[prog], prog, [*words, "--help"]) == 0
    assert "Usage" in capsys.readouterr().out


@pytest.mark.parametrize(("prog", "name"), SUBCOMMANDS)
def test_an_option_that_no_subcommand_has_is_refused_by_each(capsys, prog, name):
    assert console.run(APPS[prog], prog, [name, "--no-such-option"]) == console.BAD_INPUT


def test_a_group_of_options_reaches_the_command_as_one_object():
    status, calls = painted(["hall", "--floor", "white", "--twice"])

    assert status == console.YES
    assert calls == [("hall", Colours(wall="black", floor="white"), True)]


def test_what_is_missing_is_bad_use():
    assert painted([]) == (console.BAD_INPUT, [])
