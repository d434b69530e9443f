import numpy as np
import pytest

from sim.meshes import build_facets, build_mesh, cut_at_height
from sim.world import Prism
from tests.sim.small_worlds import box_world


def test_a_mesh_has_the_volume_of_its_prisms():
    world = box_world()
    vertices, triangles = build_mesh(world.furniture)
    corners = vertices[triangles]
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6

    assert volume == pytest.approx(1.0 * 0.7 * 0.75)  # the bottom lies at z = 0 and adds nothing


def test_facets_look_outwards():
    corners, normals = build_facets(box_world().furniture)
    middle = np.array([3.5, 1.35, 0.3])

    assert np.allclose(np.linalg.norm(normals, axis=1), 1.0)
    assert (np.einsum("ij,ij->i", corners - middle, normals) > 0).all()


def test_what_begins_above_the_cut_is_gone():
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    low, high = cut_at_height([Prism(square, 0.5), Prism(square, 2.0, 1.0), Prism(square, 2.0, 1.4)], 1.3)

    assert (low.top, high.bottom, high.top) == (0.5, 1.0, 1.3)
