"""Linkages for tests: planar and single-loop ones from points and axes, and any linkage seen from another frame."""

from __future__ import annotations

import msgspec
import numpy as np
from numpy.typing import NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.limb import Joint, Linkage
from steeplejack.mechanics.limb.linkage import NEEDED

Array = NDArray[np.float64]


def linkage(joints: list[Joint], base: str, output: str) -> Linkage:
    """A linkage of all the links its joints name."""
    links = tuple(dict.fromkeys(link for joint in joints for link in joint.links))
    return Linkage(name="test", description="", source="", links=links, base=base, output=output, joints=tuple(joints))


def loop(joints: list[dict[str, object]], output: int = 2) -> Linkage:
    """A single loop of joints, each given by its kind and geometry; link 0 is fixed."""
    count = len(joints)
    made = [
        msgspec.convert({"name": f"j{k}", "links": (f"{k}", f"{(k + 1) % count}"), **joint}, type=Joint)
        for k, joint in enumerate(joints)
    ]
    return linkage(made, "0", f"{output}")


def hinges(points: list[tuple[float, float]]) -> Linkage:
    """A planar loop of hinges parallel to Z."""
    return loop([{"kind": "revolute", "point": (x, y, 0.0), "axis": (0.0, 0.0, 1.0)} for x, y in points])


def random_loop(kinds: list[str], rng: np.random.Generator) -> Linkage:
    """A single loop of joints at random places."""
    joints = list[dict[str, object]]()
    for kind in kinds:
        joint: dict[str, object] = {"kind": kind}
        if kind != "spherical":
            joint["axis"] = tuple(rng.normal(size=3).tolist())
        if kind != "prismatic":
            joint["point"] = tuple(rng.normal(size=3).tolist())
        joints.append(joint)
    return loop(joints)


def seen_from(linkage: Linkage, rotation: Array, translation: Array, scale: float) -> Linkage:
    """The linkage enlarged, turned and moved."""

    def place(joint: Joint) -> Joint:
        fields: dict[str, object] = {}
        for name in ("axis", "second_axis"):
            if (axis := getattr(joint, name)) is not None:
                fields[name] = tuple(float(x) for x in rotation @ np.array(axis))
        if joint.point is not None:
            fields["point"] = tuple(float(x) for x in scale * (rotation @ np.array(joint.point)) + translation)
        if joint.pitch is not None:
            fields["pitch"] = scale * joint.pitch
        return msgspec.structs.replace(joint, **fields)

    return msgspec.structs.replace(linkage, joints=tuple(place(joint) for joint in linkage.joints))


def any_linkage(rng: np.random.Generator) -> Linkage | None:
    """A few links and joints of all kinds with coordinates that often coincide or align; None where that is none."""

    def vector() -> tuple[float, ...]:
        return tuple(rng.choice([0.0, 0.0, 1.0, -1.0, 0.5, 0.25], size=3).tolist())

    links = int(rng.integers(2, 6))
    joints = list[Joint]()
    try:
        for k in range(int(rng.integers(links - 1, links + 4))):
            pair = (k, k + 1) if k < links - 1 else rng.choice(links, 2, replace=False)
            kind = str(rng.choice(list(NEEDED)))
            fields = {name: 0.25 if name == "pitch" else vector() for name in NEEDED[kind]}
            ends = (f"{pair[0]}", f"{pair[1]}")
            joints.append(msgspec.convert({"name": f"j{k}", "kind": kind, "links": ends, **fields}, type=Joint))
    except InputError:
        return None
    return linkage(joints, "0", f"{links - 1}")
