"""Robots on their servos: standing, landing, pushed. Truths are converged references of references.json."""

import json
from pathlib import Path

from . import robots
from .parts import case, floor, measure, placed

REFERENCES = Path(__file__).resolve().parents[1] / "references.json"
DERIVATION = (
    "reference of `runner` (exact friction, dopri5 at 1e-10, contacts at 1e-8), which make_references.py "
    "made; the error is its distance from one at 1e-9"
)


def references():
    return json.loads(REFERENCES.read_text()) if REFERENCES.exists() else {}


def cases():
    known = references()
    # Peak of the push, N, and its point in the frame of the pushed link.
    kinds = [
        (robots.of_robot_file("hoap2"), "HOAP-2", 8.0, "torso"),
        (robots.humanoid(), "a humanoid of 33 kg", 60.0, "torso"),
        (robots.of_robot_file("quadruped"), "a quadruped", 30.0, "body"),
    ]
    for (body, files), label, push, link in kinds:
        name = body["name"]
        ground = robots.sole_height(body, files[f"{name}.urdf"])
        push = {
            "body": name,
            "link": link,
            "point": [0.0, 0.0, 0.1],
            "knots": [[0.2, 0, 0, 0, 0, 0, 0], [0.3, push, push / 4, 0, 0, 0, 0], [0.4, 0, 0, 0, 0, 0, 0]],
        }
        for kind, title, height, forces, duration in [
            ("stands", f"{label} stands on its servos", 0.0, [], 1.0),
            ("lands", f"{label} falls 5 cm on its feet", 0.05, [], 0.6),
            ("pushed", f"{label} stands and is pushed", 0.0, [push], 0.8),
        ]:
            title = title[0].upper() + title[1:]
            key = f"{name}-{kind}"
            reference = known.get(key)
            measures = []
            if reference:
                state = {
                    "position": reference["position"],
                    "orientation": reference["orientation"],
                    "q": reference["q"],
                }
                for quantity, unit in [("position", "m"), ("joints", "rad")]:
                    measures.append(
                        measure(
                            f"{quantity}_error",
                            f"{quantity}_distance",
                            0.0,
                            DERIVATION,
                            unit,
                            error=reference[f"{quantity}_error"],
                            body=name,
                            reference=state,
                        )
                    )
            yield (
                case(
                    key,
                    title,
                    "robots",
                    [placed(body, [0, 0, ground + height])],
                    floor(0.7, [name]),
                    duration,
                    measures,
                    forces=forces,
                ),
                files,
            )
