"""ROS domain of the tests of this process."""

import os

LONGEST_S = 120.0  # however busy the machine is
DOMAIN = 1 + os.getpid() % 100  # other tests and robots in the network do not meet these
