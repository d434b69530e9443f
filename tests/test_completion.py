"""Completion in the shell: what the commands offer when Tab is pressed."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

BIN = Path(sys.executable).parent


def offered(command, words):
    environment = os.environ | {
        f"_{command.upper()}_COMPLETE": "complete_bash",
        "COMP_WORDS": f"{command} {words}",
        "COMP_CWORD": str(len(words.split(" "))),
    }
    done = subprocess.run([BIN / command], env=environment, capture_output=True, text=True, check=False, timeout=60)
    return done.stdout.split()


@pytest.mark.parametrize(
    ("command", "words", "wanted"),
    [
        ("rectmerge", "ch", ["check"]),
        ("rectmerge", "merge --gu", ["--guess"]),
        ("rectmerge", "merge --method ro", ["robust"]),
        ("rectmerge", "merge --dialect ros", ["ros1"]),
        ("rectbench", "gen", ["generate"]),
    ],
)
def test_tab_offers_what_fits(command, words, wanted):
    assert offered(command, words) == wanted


@pytest.mark.parametrize("command", ["rectmerge", "rectbench"])
def test_the_script_for_the_shell_is_printed(command):
    environment = os.environ | {f"_{command.upper()}_COMPLETE": "source_bash"}
    done = subprocess.run([BIN / command], env=environment, capture_output=True, text=True, check=False, timeout=60)

    assert done.returncode == 0
    assert f"complete -o default -F _{command}_completion {command}" in done.stdout
