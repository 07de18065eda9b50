"""Programs in files are verified, one after the other, with the progress shown."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from ifs_cad.fabrication.machining.job import Job, find_job, read_job
from ifs_cad.fabrication.machining.verification import Verification
from ifs_cad.fabrication.machining.verify import verify_file
from ifs_cad.workflow.supervise import Listener


def verify_programs(
    programs: Sequence[str | os.PathLike[str]],
    job: str | os.PathLike[str] | None = None,
    *,
    simulate: bool = True,
    listener: Listener | None = None,
) -> list[Verification]:
    """Verify programs against the job that they belong to.

    Parameters
    ----------
    programs : paths
    job : path of what they are to make; by default `job.json` in the folder of each, or above
    simulate : bool, whether to take from each sheet all that the cutters pass over
    listener : Listener, optional
        Hears how far it has come.

    Raises
    ------
    InputError
        A file that cannot be read, or a job that does not hold the sheet.
    """
    listener = listener or Listener()
    jobs: dict[Path, Job] = {}
    found = []
    for number, program in enumerate(map(Path, programs)):
        place = find_job(program) if job is None else Path(job)
        listener.stage(f"verifying {program.name}", number, len(programs))
        if place not in jobs:
            jobs[place] = read_job(place)
        found.append(verify_file(program, jobs[place], simulate=simulate))
        listener.stage(f"verifying {program.name}", number + 1, len(programs))
    return found
