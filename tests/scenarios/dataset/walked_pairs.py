"""A pair of the walked office, and what it was made from."""

from dataclasses import replace

from scenarios.pairs.map_view import MapSpec
from scenarios.pairs.pair import MapPair, PairInputs, make_pair
from tests.sim.small_worlds import walked_log

SPECS = MapSpec(turn_deg=25.0, hide_resolution=False), MapSpec(resolution=0.06, turn_deg=-40.0, turn="image")


def made(*specs: MapSpec, noise: int = 0) -> tuple[MapPair, PairInputs]:
    """A pair of the walked office, and what it was made from."""
    log = walked_log()
    log = replace(log, a=log.a.until(30.0), b=log.b.until(24.0))
    a, b = specs or SPECS
    return make_pair(log, a, b, 5, noise=noise), PairInputs(log=log, spec_a=a, spec_b=b)
