"""Times of several jobs, taken in turns so that all of them meet the same machine.

The time of one call is the smaller of its wall time and its processor time (user and system, all
threads): wall time overstates when others use the machine, processor time where threads help. On
a quiet machine both are the same for one thread.
"""

from __future__ import annotations

import gc
import statistics
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

COLLECT_AFTER = 0.1  # s; rubbish is taken out, untimed, after calls that take longer


@dataclass(frozen=True)
class Timing:
    """What repetitions of one job took.

    Attributes
    ----------
    best : float, s, the smallest of all calls
    median : float, s, of the same times
    wall : float, s, median of the wall times; how far it lies above `best` tells the noise
    calls : int
    """

    best: float
    median: float
    wall: float
    calls: int


def interleaved(
    jobs: Mapping[str, Callable[[], Any]], rounds: int, calls: Mapping[str, int] | None = None
) -> dict[str, Timing]:
    """Time jobs in turns: A B A B ...

    Parameters
    ----------
    jobs : named functions without parameters
    rounds : int
        How often each job has its turn; one turn more comes first and is not timed.
    calls : how often a job is called in its turn, where it is not once
    """
    calls = calls or {}
    times: dict[str, list[tuple[float, float]]] = {name: [] for name in jobs}
    for turn in range(rounds + 1):
        for name, job in jobs.items():
            for _ in range(calls.get(name, 1)):
                took = _timed(job)
                if turn:
                    times[name].append(took)
                if took[0] > COLLECT_AFTER:
                    gc.collect()
    return {name: _summary(taken) for name, taken in times.items()}


def _timed(job: Callable[[], Any]) -> tuple[float, float]:
    """Return wall and processor time of one call, s."""
    gc.disable()
    try:
        processor, wall = time.process_time(), time.perf_counter()
        result = job()
        wall, processor = time.perf_counter() - wall, time.process_time() - processor
        del result
    finally:
        gc.enable()
    return wall, processor


def _summary(times: list[tuple[float, float]]) -> Timing:
    smaller = [min(pair) for pair in times]
    walls = [wall for wall, _ in times]
    return Timing(min(smaller), statistics.median(smaller), statistics.median(walls), len(times))
