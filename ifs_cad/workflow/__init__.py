"""Whole jobs: a part script becomes files, a file is checked.

Kernel calls hold the interpreter lock and cannot be interrupted, so a job runs in a process of
its own (`worker`), watched by a light parent that loads no kernel (`supervise`, `build`). Files
are made in a hidden folder beside their target and moved there at the end (`staging`).
"""
