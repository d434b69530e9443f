"""Settings of the whole suite."""

from hypothesis import settings

# The first example of a property may compile a kernel, and the machine may be busy: time says nothing here.
settings.register_profile("compiled", deadline=None)
settings.register_profile("long", deadline=None, max_examples=2000)  # `make fuzz`
settings.load_profile("compiled")
