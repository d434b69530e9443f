"""Command-line application with the options that all commands share, each declared once."""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Callable
from typing import Annotated, Any, get_type_hints

import typer

from rectmerge import __version__
from rectmerge.cli import console


def _show_version(asked: bool) -> None:
    if asked:
        typer.echo(__version__)
        raise typer.Exit(console.YES)


Json = Annotated[bool, typer.Option("--json", metavar="", help="Print JSON instead of text.")]
Version = Annotated[
    bool,
    typer.Option("--version", metavar="", help="Show the version and exit.", callback=_show_version, is_eager=True),
]
Quiet = Annotated[
    bool,
    typer.Option("--quiet", "-q", metavar="", help="Keep progress and notes off stderr.", callback=console.set_quiet),
]
Debug = Annotated[bool, typer.Option("--debug", metavar="", help="Show the traceback of any error.")]
COMMON_OPTIONS = {"quiet": Quiet, "debug": Debug}
SETTINGS = {"help_option_names": ["-h", "--help"]}


class App(typer.Typer):
    """Typer application whose commands all take the common options, and groups of options as dataclasses.

    A parameter of a command whose annotation is a dataclass stands for one option per field: the annotation of the
    field declares the option, its default is the option's default. The command gets the dataclass.

    Parameters
    ----------
    about
        Help text of the application.
    """

    def __init__(self, about: str) -> None:
        super().__init__(
            help=about,
            context_settings=SETTINGS,
            no_args_is_help=True,
            add_completion=True,
            pretty_exceptions_enable=False,
        )
        self.callback()(_common)

    def command(  # type: ignore[override] # typer's many settings, passed on as they are
        self, name: str | None = None, **settings: Any
    ) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
        """Register a function as a command; it takes the common options without declaring them."""
        register = super().command(name, **settings)

        def decorate(function: Callable[..., Any]) -> Callable[..., Any]:
            register(expand_options(function))
            return function

        return decorate


def expand_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function with one parameter per option for a function that takes options grouped in dataclasses.

    Raises
    ------
    TypeError
        If two options have one name.
    """
    hints = get_type_hints(function, include_extras=True)
    groups: dict[str, Any] = {}
    options: list[inspect.Parameter] = []
    for parameter in inspect.signature(function).parameters.values():
        hint = hints[parameter.name]
        if dataclasses.is_dataclass(hint):
            groups[parameter.name] = hint
            options += _field_options(hint)
        else:
            options.append(_option(parameter.name, hint, parameter.default))
    options += [_option(name, hint, False) for name, hint in COMMON_OPTIONS.items()]

    def call(**values: Any) -> Any:
        for name in COMMON_OPTIONS:
            del values[name]
        for name, group in groups.items():
            values[name] = group(**{field.name: values.pop(field.name) for field in dataclasses.fields(group)})
        return function(**values)

    call.__name__, call.__doc__ = function.__name__, function.__doc__
    call.__annotations__ = {option.name: option.annotation for option in options}
    call.__signature__ = inspect.Signature(options)  # type: ignore[attr-defined] # read by inspect.signature
    return call


def _field_options(group: Any) -> list[inspect.Parameter]:
    hints = get_type_hints(group, include_extras=True)
    return [
        _option(
            field.name,
            hints[field.name],
            inspect.Parameter.empty if field.default is dataclasses.MISSING else field.default,
        )
        for field in dataclasses.fields(group)
    ]


def _option(name: str, annotation: Any, default: Any) -> inspect.Parameter:
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=annotation)


def _common(version: Version = False, quiet: Quiet = False, debug: Debug = False) -> None:
    """Take the common options before a subcommand, too."""
