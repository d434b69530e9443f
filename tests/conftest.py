"""Settings of the whole suite."""

import os

from hypothesis import settings

# The first example of a property may compile a kernel, and the machine may be busy: time says nothing here. Where CI is
# set, as CI systems do, the examples are the same in every run, so that it judges the change and not the luck.
settings.register_profile("compiled", deadline=None, derandomize=bool(os.environ.get("CI")))
settings.register_profile("fast", deadline=None, max_examples=20)  # `make test-fast`
settings.register_profile("long", deadline=None, max_examples=2000)  # `make fuzz`
settings.load_profile("compiled")
