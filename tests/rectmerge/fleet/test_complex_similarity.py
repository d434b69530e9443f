import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rectmerge.fleet.complex_similarity import ComplexSimilarity, to_complex
from rectmerge.similarity import Similarity

numbers = st.floats(-50, 50)
placements = st.builds(Similarity, st.floats(0.2, 5), st.floats(-3, 3), numbers, numbers)


@given(placements, placements, st.tuples(numbers, numbers))
def test_the_complex_form_does_what_the_similarity_does(first, second, point):
    one, two = map(ComplexSimilarity.from_similarity, (first, second))
    both = two @ one

    assert to_complex((second @ first).apply(point)) == pytest.approx(both.apply(to_complex(point)), abs=1e-9)
    assert both.to_similarity().matrix == pytest.approx((second @ first).matrix, abs=1e-9)
    assert one.inverse().apply(one.apply(to_complex(point))) == pytest.approx(to_complex(point), abs=1e-9)
    assert one.scale == pytest.approx(first.scale)
    assert np.iscomplexobj(to_complex([[1, 2]]))
