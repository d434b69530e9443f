"""Why a placement is not accepted, in one line that names the likeliest cause and what to do about it."""

from __future__ import annotations

from collections.abc import Mapping

from rectmerge.robust.verdict import ACCEPT_AT, Evidence, without

LEAST_FREE_CELLS = 1500  # of the working grid; less shows no room
SPECKLED = 0.06  # share of a map's known cells that stand alone; a good scanner leaves 0.02
BESIDE = 0.15  # share of the walls that lie beside each other, not on each other, from which maps seem bent
BENT_SUPPORT = 0.25  # likelihood per wall point of maps that fit each other in spite of it


def accepted(evidence: Evidence) -> str:
    """Say why a placement is accepted."""
    said = f"the walls of both maps agree over {evidence.overlap:.0%} of the smaller free area"
    return f"{said}; they are bent against each other" if _is_bent(evidence) else said


def ambiguous(evidence: Evidence) -> str:
    """Say why none of several placements is accepted."""
    return (
        f"more than one placement explains the walls (the best has {evidence.probability:.0%}): the building repeats "
        "itself or is symmetric; look at the candidates, or map more of what tells the places apart"
    )


def rejected(evidence: Evidence, quality: Mapping[str, Mapping[str, float]], free_cells: Mapping[str, int]) -> str:
    """Say why the best placement is not accepted: the first cause that the numbers show.

    Parameters
    ----------
    evidence
        Of the best placement.
    quality
        Of each map, by name ("a", "b"), as `rectmerge.quality` measures it.
    free_cells
        Free cells of the working grid of each map, by name.
    """
    if without(evidence, is_at_limit=False).probability >= ACCEPT_AT:
        return "the maps fit best at a scale beyond the bounds of the search: widen --scale, or check the resolutions"
    if without(evidence, slack_cells=0.0).probability >= ACCEPT_AT:
        return (
            f"the walls in common do not hold the placement: it can slide by {evidence.slack_cells:.0f} cells; map a "
            "corner or a crossing wall that both maps share"
        )
    for name, cells in free_cells.items():
        if cells < LEAST_FREE_CELLS:
            return f"map {name.upper()} shows too little free space: map at least a few rooms"
    for name, measured in quality.items():
        if measured["speckle"] >= SPECKLED:
            return (
                f"map {name.upper()} is too noisy ({measured['speckle']:.0%} of its cells are specks): remove the "
                "specks, or map again"
            )
    if _is_bent(evidence):
        return (
            "the walls lie beside each other, not on each other: the maps are bent against each other too much for one "
            "similarity; close loops in the mapping, or merge smaller parts"
        )
    if evidence.likelihood <= 0:
        return "no placement explains the walls better than chance: these seem to be maps of different places"
    return (
        f"the best placement agrees too little (overlap {evidence.overlap:.0%} of the smaller map, "
        f"{evidence.missing:.0%} of its walls contradicted): the maps are of different places, or share no room"
    )


def _is_bent(evidence: Evidence) -> bool:
    """Whether the maps fit each other, but with much of the walls beside each other."""
    return evidence.near - evidence.met >= BESIDE and evidence.support >= BENT_SUPPORT
