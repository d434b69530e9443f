"""Page docs/commands.md, made from the commands themselves by `python -m scenarios.cli.docs_page`."""

from __future__ import annotations

import inspect
import re
from typing import Any

import typer

import rectmerge.cli.main
import scenarios.cli.main

HEAD = """# Commands

Made from the commands themselves (`make docs`); `COMMAND --help` says the same. `--quiet` keeps progress and notes off
stderr, `--debug` shows the traceback of any error; every command has both. `--install-completion` teaches the shell to
complete commands, options and names.

Exit status: 0 yes (merged; no regression; the chain ran), 1 no (rejected; regression), 2 bad input or bad use,
3 ambiguous, 70 internal error, 130 interrupted. Answers go to stdout, progress and notes to stderr.
"""
COMMON = {"--quiet", "--debug", "--help"}


def page() -> str:
    """Return the page."""
    parts = [HEAD]
    for name, app in (("rectmerge", rectmerge.cli.main.app), ("rectbench", scenarios.cli.main.app)):
        commands: dict[str, Any] = typer.main.get_command(app).commands  # type: ignore[attr-defined]
        parts += [f"\n## {name}\n", *(_section(name, each, commands[each]) for each in commands)]
    return "".join(parts)


def _section(program: str, name: str, command: Any) -> str:
    arguments = [parameter for parameter in command.params if parameter.param_type_name == "argument"]
    options = [
        parameter
        for parameter in command.params
        if parameter.param_type_name == "option" and not COMMON & set(parameter.opts)
    ]
    about = inspect.cleandoc(command.help or "")
    words = [
        program,
        name,
        *map(_argument, arguments),
        *(_words(parameter) for parameter in options if parameter.required),
    ]
    lines = [f"\n### {program} {name}\n", f"`{' '.join(words)}`\n", f"{about}\n"]
    if arguments:
        lines.append(
            "\n".join(f"- `{_argument(parameter)}`: {_plain(parameter.help)}" for parameter in arguments) + "\n"
        )
    if options:
        lines.append(
            "\n".join(f"- {_option(parameter)}: {_plain(parameter.help)}{_default(parameter)}" for parameter in options)
            + "\n"
        )
    return "\n".join(lines)


def _argument(argument: Any) -> str:
    name = (argument.metavar or argument.name.upper()).strip("{}[]")
    return name if argument.required else f"[{name}]"


def _option(option: Any) -> str:
    return f"`{_words(option, ', ')}`" + (" (required)" if option.required else "")


def _words(option: Any, between: str = "") -> str:
    """Write an option with what it takes, by all of its names or the shortest."""
    names = between.join(option.opts) if between else min(option.opts, key=len)
    return names if option.is_flag else f"{names} {option.metavar or 'N'}"


def _default(option: Any) -> str:
    is_told = not (option.is_flag or option.required or option.default in (None, [], ()))
    return f" Default: `{option.default}`." if is_told else ""


def _plain(text: str | None) -> str:
    return re.sub(r"\s+", " ", text or "").strip()


if __name__ == "__main__":
    typer.echo(page(), nl=False)
