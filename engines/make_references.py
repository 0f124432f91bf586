"""Writes references.json: final states of the robots of the cases, by this project's runner with tight tolerances.

    python3 make_references.py

Run make_cases.py before it (for the cases) and after it (for their truths).
"""

import json
from pathlib import Path

import numpy

from stiction_engines import case
from stiction_engines.adapters.stiction import Adapter

TIGHT, LOOSE = 1e-10, 1e-9


def main():
    engine = Adapter()
    exact = next(s for s in engine.settings() if s.name == "exact")
    references = {}
    for known in case.read_all():
        if known.family != "robots":
            continue
        tight, loose = (engine.record(known, exact, t).bodies[known.bodies[0].name] for t in (TIGHT, LOOSE))
        rms = lambda difference: float(numpy.sqrt(numpy.mean(difference**2)))
        references[known.name] = {
            "runner": engine.version(),
            "position": tight.position[-1].tolist(),
            "orientation": tight.orientation[-1].tolist(),
            "q": tight.q[-1].tolist(),
            "position_error": float(numpy.linalg.norm(tight.position[-1] - loose.position[-1])),
            "joints_error": rms(tight.q[-1] - loose.q[-1]),
        }
        print(known.name, references[known.name]["position_error"], references[known.name]["joints_error"])
    (Path(__file__).parent / "references.json").write_text(json.dumps(references, indent=1) + "\n")


if __name__ == "__main__":
    main()
