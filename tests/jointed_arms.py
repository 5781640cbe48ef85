"""Two-link arms that several tests hold handles with: unlike each other in every value that matters."""

from __future__ import annotations

from typing import Any

ARM: dict[str, Any] = {
    "kind": "two-link",
    "base": [0.03, -0.44],
    "elbow": "right",
    "link_length": [0.34, 0.31],
    "link_mass": [0.9, 0.4],
    "link_centre": [0.25, 0.17],
    "link_inertia": [0.0099, 0.0036],
    "joint_damping": [0.04, 0.03],
    "rotor_inertia": [0.02, 0.012],
}
OTHER: dict[str, Any] = {**ARM, "base": [-0.05, -0.42], "elbow": "left"}
