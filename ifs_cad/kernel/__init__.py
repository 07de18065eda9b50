"""Exact solids: the only room that imports cadquery and OCP."""

from ifs_cad.libraries import require

# Before any module of this room: a missing system library is explained in a sentence, and the
# hook that attaches the Workplane methods then imports these modules whole, not half-way through
# the one that happened to import cadquery first.
require("cadquery", "exact solids")
