"""Errors that rectmerge raises on purpose.

::

    RectMergeError                 base of all
    ├── InputError (ValueError)    a value or a combination of values that cannot be used
    │   ├── MapFileError           a map file that cannot be read or written
    │   ├── MethodError            an unknown method, or a field it does not have
    │   ├── ScenarioError          a suite file with a key or value that is not allowed
    │   └── DatasetError           a data set on disk that does not keep its layout
    └── SimulationError            a task that the simulator cannot do

A hard question honestly unanswered is not an error: `align` returns a falsy result with a reason.
"""


class RectMergeError(Exception):
    """Base of the errors that rectmerge raises on purpose."""


class InputError(RectMergeError, ValueError):
    """Value, or a combination of values, that cannot be used."""


class MapFileError(InputError):
    """Map file that cannot be read or written; the message names the file and the remedy."""


class MethodError(InputError):
    """Unknown method, or a field that a method does not have."""


class ScenarioError(InputError):
    """Suite file with a key or a value that is not allowed; the message gives its path."""


class DatasetError(InputError):
    """Data set on disk that does not keep its layout."""


class SimulationError(RectMergeError):
    """Task that the simulator cannot do."""
