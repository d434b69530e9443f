"""Elastic alignment of two maps: B is bent smoothly until its walls lie on A's, and the walls say if that holds."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rectmerge.alignment import Alignment
from rectmerge.elastic.acceptance import Board, HeldBack, hold_back
from rectmerge.elastic.bend import Bend, BendEvidence
from rectmerge.elastic.faces import Faces
from rectmerge.elastic.fit import ElasticFit
from rectmerge.elastic.lattice import Displacement
from rectmerge.elastic.matching import FacePair
from rectmerge.elastic.params import AcceptanceParams, BendParams
from rectmerge.elastic.transform import BentTransform
from rectmerge.elastic.uncertainty import jackknife_std
from rectmerge.elastic.warp import Warp
from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid, pixels_to_map_frame
from rectmerge.similarity import Similarity

DEFAULT_PARAMS = BendParams()


def unbend(
    a: OccupancyGrid, b: OccupancyGrid, placement: Alignment | Similarity, *, params: BendParams = DEFAULT_PARAMS
) -> Bend:
    """Bend map B onto map A where no similarity fits, or say why not.

    Parameters
    ----------
    a, b
        The two maps.
    placement
        The similarity from B's pixels to A's, taken as right; or an alignment, whose best candidate is taken unless it
        is rejected: some wrong placements pass the test, of a building turned by half for example.
    params
        Weights, steps and thresholds.

    Returns
    -------
    Bend
        Truthy where walls that the displacement was not fitted to meet better with it. Else it is the similarity, with
        the reason. The same maps give the same bend.

    Raises
    ------
    InputError
        If the alignment has no candidate.

    Notes
    -----
    T(p) = x + u(x) with x the placed point and u on a lattice of cubic B-splines: D. Rueckert et al., IEEE Transactions
    on Medical Imaging 1999, DOI 10.1109/42.796284. Faces of both maps are paired both ways with the nearest that looks
    the same way; Gauss-Newton steps with Tukey's weights bring them together, against a prior for which turning is free
    and stretching is dear, as drift has it. The test: fitted without a quarter of the squares that A is cut into, the
    displacement must bring the walls in these squares closer together, and so for each quarter.
    """
    started = time.perf_counter()
    if isinstance(placement, Alignment) and not placement.candidates:
        raise InputError(f"the answer has no candidate to bend: {placement.verdict}, {placement.reason}")
    pixels = placement.candidates[0].pixels if isinstance(placement, Alignment) else placement
    refused = Bend(accepted=False, reason="", pixels=pixels, b_to_a=pixels_to_map_frame(pixels, a, b))
    if isinstance(placement, Alignment) and placement.verdict == "rejected":
        return replace(refused, reason=f"the placement is rejected, and no bend makes it right: {placement.reason}")
    bend = _unbend(a, b, refused, params)
    return replace(bend, seconds=time.perf_counter() - started)


def _unbend(a: OccupancyGrid, b: OccupancyGrid, refused: Bend, params: BendParams) -> Bend:
    """Try the stages in turn; each may refuse."""
    faces_a, faces_b = (Faces.from_grid(grid, params.faces) for grid in (a, b))
    accept = params.accept
    if min(len(faces_a.points), len(faces_b.points)) < accept.min_faces:
        return replace(refused, reason="a map shows too few walls to bend the other by")
    pair = FacePair.under(refused.pixels, faces_a, faces_b, params.faces)
    fitting = ElasticFit.of_pair(pair, params.fit)
    none = Displacement.none(fitting.lattice)
    distances = _wall_distances(pair, none, none, accept)
    if len(distances) < accept.min_faces:
        return replace(refused, reason="the maps have too few walls in common to bend one by the other")
    apart = _upper_quartile(distances)
    evidence = BendEvidence(walls_before=apart)
    if apart < accept.min_distance_cells:
        return replace(refused, reason=_unmeasurable(apart), evidence=evidence)
    board = Board.over(pair, accept.square * pair.diagonal)
    held = hold_back(fitting, board, accept)
    evidence = replace(evidence, held_back_cost=held.cost_ratio, gain_t=held.gain_t)
    min_gain_t = accept.min_gain_t if apart >= accept.clear_distance_cells else accept.unclear_gain_t
    if reason := _refusal(held, accept, min_gain_t):
        if apart < AcceptanceParams().min_distance_cells:  # it was tried all the same
            reason = _unmeasurable(apart)
        return replace(refused, reason=reason, evidence=evidence)
    return _fit(a, replace(refused, evidence=evidence), fitting, held, accept)


def _unmeasurable(apart: float) -> str:
    return f"the maps do not bend measurably: three in four of their walls lie within {apart:.1f} cells"


def _fit(a: OccupancyGrid, refused: Bend, fitting: ElasticFit, held: HeldBack, accept: AcceptanceParams) -> Bend:
    """Fit to all faces once the test is passed, and refuse a displacement that folds or stretches too much."""
    pair = fitting.pair
    fitted = fitting.fit(pair.sample_a, pair.sample_b)
    determinant, least, greatest = fitted.extremes()
    none = Displacement.none(fitting.lattice)
    moves = np.linalg.norm(fitted.at(pair.placed[pair.sample_b]), axis=1)
    evidence = replace(
        refused.evidence,
        walls_before=_upper_quartile(_wall_distances(pair, none, fitted, accept)),
        walls_after=_upper_quartile(_wall_distances(pair, fitted, none, accept)),
        largest_move=float(moves.max()),
        stretch=(least, greatest),
    )
    if determinant < accept.min_determinant or least < accept.min_stretch or greatest > accept.max_stretch:
        reason = f"the maps bend, but only a stretch of {least:.2f} to {greatest:.2f} would bring their walls together"
        return replace(refused, reason=reason, evidence=evidence)
    std_cells = jackknife_std(held.fits, fitting.lattice.nodes())
    reason = (
        f"bent by up to {evidence.largest_move:.0f} cells: three in four walls lie within "
        f"{evidence.walls_after:.1f} cells, {evidence.walls_before:.1f} before; walls held back from the fit agree"
    )
    return replace(
        refused,
        accepted=True,
        reason=reason,
        warp=Warp(refused.pixels, fitted),
        transform=BentTransform.from_pixels(refused.b_to_a, fitted, std_cells, a),
        evidence=evidence,
    )


def _wall_distances(
    pair: FacePair, displacement: Displacement, other: Displacement, accept: AcceptanceParams
) -> NDArray[np.float64]:
    """Measure faces that have a partner under both displacements: their distance across the wall under the first."""
    reach = accept.reach_cells(pair.diagonal)
    under, too = (pair.moved(d, pair.sample_a, pair.sample_b).match(reach) for d in (displacement, other))
    return np.concatenate([
        np.abs(m.across()[m.is_matched & n.is_matched]) for m, n in zip(under, too, strict=True)
    ])  # fmt: skip


def _upper_quartile(distances: NDArray[np.float64]) -> float:
    """Return the distance within which three in four walls lie: a shift along an axis moves half of them apart."""
    return float(np.quantile(distances, 0.75))


def _refusal(held: HeldBack, accept: AcceptanceParams, min_gain_t: float) -> str:
    """Return why the test is not passed; empty where it is."""
    if held.squares < accept.min_squares or held.met < accept.min_met:
        return f"too few walls of both maps meet to bend one by the other: {held.met:.0%} of them"
    if held.cost_ratio < accept.max_cost_ratio and held.gain_t > min_gain_t:
        return ""
    gain = "gain nothing" if held.cost_ratio >= 1 else f"gain {1 - held.cost_ratio:.0%}"
    return f"the maps bend, but not in a way that holds where it was not fitted: walls held back from the fit {gain}"
