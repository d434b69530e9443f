"""Partners of wall faces in the other map, both ways, under a displacement."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rectmerge.elastic.faces import Faces
from rectmerge.elastic.lattice import Displacement
from rectmerge.elastic.params import FaceParams
from rectmerge.similarity import Similarity

INVERSE_STEPS, INVERSE_CELLS = 4, 0.05  # a partner is looked up in whole cells


@dataclass(frozen=True, slots=True, eq=False)
class Matches:
    """Faces of one map and their partners in the other.

    Parameters
    ----------
    points
        Shape (N, 2): B's face of each match before the displacement, in A's pixels.
    normals
        Shape (N, 2): the normal to measure along, A's; of two faces that look opposite ways, the one turned round.
    offsets
        Shape (N, 2): from B's displaced face to A's.
    is_matched
        Shape (N,): whether the two faces are partners.
    """

    points: NDArray[np.float64]
    normals: NDArray[np.float64]
    offsets: NDArray[np.float64]
    is_matched: NDArray[np.bool_]

    def across(self) -> NDArray[np.float64]:
        """Return the signed distance across the wall, (N,)."""
        distance: NDArray[np.float64] = np.einsum("nk,nk->n", self.offsets, self.normals)
        return distance


@dataclass(frozen=True, slots=True, eq=False)
class FacePair:
    """Faces of two maps under a similarity, a sample of each.

    Parameters
    ----------
    a, b
        All faces of both maps.
    placed, placed_normals
        Shape (N, 2): B's faces and normals, all of them, moved into A's pixels.
    back
        Similarity from A's pixels to B's.
    sample_a, sample_b
        Numbers of the faces to match, evenly spread, within reach of the other map.
    weight_a, weight_b
        Cells of A that each sampled face stands for.
    diagonal
        Of the bounding box of A's faces, in cells of A.
    pair_cos
        Least cosine between the normals of partners.
    """

    a: Faces
    b: Faces
    placed: NDArray[np.float64]
    placed_normals: NDArray[np.float64]
    back: Similarity
    sample_a: NDArray[np.intp]
    sample_b: NDArray[np.intp]
    weight_a: float
    weight_b: float
    diagonal: float
    pair_cos: float

    @classmethod
    def under(cls, pixels: Similarity, a: Faces, b: Faces, params: FaceParams) -> FacePair:
        """Place B's faces by a similarity between pixels and take a sample of both maps; each map has a face."""
        back = pixels.inverse()
        placed = pixels.apply(b.points)
        turn = Similarity(angle=pixels.angle)
        diagonal = float(np.hypot(*np.ptp(a.points, axis=0)))
        margin = params.margin * diagonal
        near_b = _near(placed, a.points, margin)
        near_a = _near(back.apply(a.points), b.points, margin * back.scale)
        sample_a, sample_b = (near[:: max(1, -(-len(near) // params.max_faces))] for near in (near_a, near_b))
        return cls(
            a, b, placed, turn.apply(b.normals), back, sample_a, sample_b,
            len(near_a) / max(1, len(sample_a)), len(near_b) * pixels.scale / max(1, len(sample_b)),
            diagonal, params.pair_cos,
        )  # fmt: skip

    def moved(self, displacement: Displacement, of_a: NDArray[np.intp], of_b: NDArray[np.intp]) -> MovedFaces:
        """Move faces `of_b` of B by a displacement, and faces `of_a` of A back by it."""
        before = displacement.undo(self.a.points[of_a], tolerance=INVERSE_CELLS, max_steps=INVERSE_STEPS)
        return MovedFaces(self, displacement, of_a, of_b, before, displacement.apply(self.placed[of_b]))

    def in_free_space(self, of_a: NDArray[np.intp], of_b: NDArray[np.intp]) -> NDArray[np.bool_]:
        """Return whether the other map has free space where the similarity puts a face, (N,); B's faces first."""
        in_b = self.b.in_free_space(self.back.apply(self.a.points[of_a]))
        return np.concatenate([self.a.in_free_space(self.placed[of_b]), in_b])


@dataclass(frozen=True, slots=True, eq=False)
class MovedFaces:
    """Faces of both maps under a displacement, ready to be matched.

    Parameters
    ----------
    pair
        All faces of both maps.
    displacement
        The displacement.
    of_a, of_b
        Numbers of the faces, (N,) and (M,).
    before
        Shape (N, 2): A's faces before the displacement, in A's pixels.
    after
        Shape (M, 2): B's faces after it.
    """

    pair: FacePair
    displacement: Displacement
    of_a: NDArray[np.intp]
    of_b: NDArray[np.intp]
    before: NDArray[np.float64]
    after: NDArray[np.float64]

    def match(self, reach: float) -> tuple[Matches, Matches]:
        """Match B's faces with A's and A's with B's: partners lie within `reach` and look the same way."""
        return self._b_to_a(reach, 1.0), self._a_to_b(reach, 1.0)

    def match_backs(self, reach: float) -> tuple[Matches, Matches]:
        """Match faces with faces of the other map that look the opposite way and behind which they should lie.

        A room that one map alone has must not reach into the wall's other side, where the other map has a room.
        """
        of_b, of_a = self._b_to_a(reach, -1.0), self._a_to_b(reach, -1.0)
        return (
            replace(of_b, is_matched=of_b.is_matched & (of_b.across() < 0)),
            replace(of_a, is_matched=of_a.is_matched & (of_a.across() < 0)),
        )

    def _b_to_a(self, reach: float, sign: float) -> Matches:
        a, points, normals = self.pair.a, self.pair.placed[self.of_b], sign * self.pair.placed_normals[self.of_b]
        partner = a.nearest(self.after, normals)
        facing, offsets = a.normals[partner], a.points[partner] - self.after
        return Matches(points, facing, offsets, self._is_pair(partner, offsets, facing, normals, reach))

    def _a_to_b(self, reach: float, sign: float) -> Matches:
        pair, points, normals = self.pair, self.pair.a.points[self.of_a], self.pair.a.normals[self.of_a]
        turned = Similarity(angle=pair.back.angle).apply(sign * normals)
        partner = pair.b.nearest(pair.back.apply(self.before), turned)
        placed = pair.placed[partner]
        offsets, facing = points - self.displacement.apply(placed), sign * pair.placed_normals[partner]
        is_pair = self._is_pair(partner, offsets, facing, normals, reach)
        return Matches(placed, normals if sign > 0 else facing, offsets, is_pair)

    def _is_pair(
        self,
        partner: NDArray[np.int64],
        offsets: NDArray[np.float64],
        facing: NDArray[np.float64],
        normals: NDArray[np.float64],
        reach: float,
    ) -> NDArray[np.bool_]:
        near = np.einsum("nk,nk->n", offsets, offsets) < reach * reach
        same = np.einsum("nk,nk->n", facing, normals) > self.pair.pair_cos
        pairs: NDArray[np.bool_] = (partner >= 0) & near & same
        return pairs


def _near(points: NDArray[np.float64], others: NDArray[np.float64], margin: float) -> NDArray[np.intp]:
    """Return the numbers of the points within the others' bounding box and a margin."""
    low, high = others.min(axis=0) - margin, others.max(axis=0) + margin
    return np.flatnonzero(((points >= low) & (points <= high)).all(axis=1))
