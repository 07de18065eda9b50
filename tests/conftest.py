"""Hypothesis profiles: HYPOTHESIS_PROFILE=ci repeats the same examples on every run."""

import os

from hypothesis import settings

# No deadline: a first call may import the CAD kernel, which takes seconds.
settings.register_profile("default", deadline=None)
settings.register_profile("ci", deadline=None, derandomize=True, print_blob=True)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "default"))
