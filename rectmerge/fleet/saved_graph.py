"""Graph read back from the record of a merge, so that a later one asks only what is new."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, get_args

import numpy as np

from rectmerge.alignment import Alignment, Candidate, ScaleReport, Verdict
from rectmerge.errors import InputError
from rectmerge.fleet.graph import AlignmentGraph, PairAnswer, Pairs, Placement, Status
from rectmerge.fleet.record import FleetFile
from rectmerge.similarity import Similarity


def read_graph(file: FleetFile, settings: Mapping[str, Any]) -> AlignmentGraph:
    """Read the graph of an earlier merge.

    Parameters
    ----------
    file
        Its record.
    settings
        Settings of the method now: those of the record have to be the same.

    Raises
    ------
    InputError
        If the settings differ, or the record is not whole.
    """
    record = file.record
    try:
        earlier = record["settings"]
        if other := [name for name in settings if earlier[name] != settings[name]]:
            remedy = "give the same, or leave out --from"
            raise InputError(f"{file.path}: its pairs were asked with other {' and '.join(other)}; {remedy}")
        names = tuple(record["maps"])
        asked = {(entry["a"], entry["b"]): _answer(entry) for entry in record["pairs"]}
        return AlignmentGraph(
            names=names,
            components=tuple(tuple(group) for group in record["components"]),
            placements={name: _placement(entry) for name, entry in record["placements"].items()},
            pairs=Pairs(names, asked),
            left_out=file.left_out,
            bridges=tuple((a, b) for a, b in record["bridges"]),
            method=record["method"],
            digests=dict(record["digests"]),
        )
    except KeyError as error:
        raise InputError(f"{file.path}: not an answer of rectmerge merge: there is no {error}; merge anew") from None
    except (ValueError, TypeError, AttributeError, IndexError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{file.path}: not an answer of rectmerge merge: {error}; merge anew") from None


def _answer(entry: Mapping[str, Any]) -> PairAnswer:
    status, told = entry["status"], entry["alignment"]
    if status not in get_args(Status):
        raise ValueError(f"no status {status!r}")
    alignment = read_alignment(told)
    return PairAnswer(status=status, reason=entry["reason"], alignment=alignment, candidate=entry["candidate"])


def read_alignment(told: Mapping[str, Any]) -> Alignment:
    """Read what `Alignment.as_dict` has written.

    Raises
    ------
    KeyError, TypeError, ValueError
        If it is something else.
    """
    if told["verdict"] not in get_args(Verdict):
        raise ValueError(f"no verdict {told['verdict']!r}")
    scale = told["scale"]
    return Alignment(
        verdict=told["verdict"],
        reason=told["reason"],
        method=told["method"],
        candidates=tuple(_candidate(one) for one in told["candidates"]),
        unit=told["candidates"][0]["b_to_a"]["unit"] if told["candidates"] else "cells",
        confidence=told["confidence"],
        scale=ScaleReport(found=scale["found"], expected=scale["expected"], source=scale["from"]),
        method_verdict=told["method_verdict"],
        checked=told["checked"],
        quality=told["quality"],
        seconds=told["seconds"],
    )


def _candidate(entry: Mapping[str, Any]) -> Candidate:
    covariance = entry["covariance"]
    return Candidate(
        b_to_a=_similarity(entry["b_to_a"]),
        pixels=Similarity.from_matrix(entry["pixels"]),
        confidence=entry["confidence"],
        overlap=entry["overlap"],
        conflict=entry["conflict"],
        covariance=None if covariance is None else np.array(covariance, np.float64),
        evidence={name: value for name, value in entry["evidence"].items() if value is not None},  # infinities
    )


def _placement(entry: Mapping[str, Any]) -> Placement:
    covariance = entry["covariance"]
    return Placement(
        reference=entry["reference"],
        to_reference=_similarity(entry["to_reference"]),
        pixels=Similarity.from_matrix(entry["pixels"]),
        confidence=entry["confidence"],
        covariance=None if covariance is None else np.array(covariance, np.float64),
        unit=entry["to_reference"]["unit"],
        rests_on=tuple((a, b) for a, b in entry["rests_on"]),
    )


def _similarity(entry: Mapping[str, Any]) -> Similarity:
    return Similarity(entry["scale"], entry["angle_rad"], *entry["translation"])
