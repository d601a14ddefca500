"""Freedoms by reciprocal screws: what the constraint wrenches of joints and limbs leave to the links.

Two sums of wrenches are formed. The links': every joint transmits the 6 - f wrenches reciprocal to its twists, so that
the twists of all links have to be reciprocal to all of them; what is dependent among them is a state of self-stress.
The platform's: a limb in series allows the sum of its joints' twists and constrains by the reciprocal system; limbs in
parallel add their constraints, and the platform has what is reciprocal to the sum; stages in series add their freedoms.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from steeplejack.mechanics.limb.graph import Arrangement, in_series, limbs, links_of, stages
from steeplejack.mechanics.limb.linkage import Joint
from steeplejack.mechanics.limb.systems import joined, met, null_space, reciprocal, row_space

Array = NDArray[np.float64]
Twists = dict[str, Array]


class LinkFreedoms(NamedTuple):
    """What the joints' wrenches leave to the links.

    Attributes:
        mobility: Independent motions of the links.
        self_stress: Independent states of internal wrench without any load, all redundant constraints together.
        output: Basis of the twists of the output, (k, 6).
    """

    mobility: int
    self_stress: int
    output: Array


class Limb(NamedTuple):
    """One way from the fixed link of a stage to its moving one.

    Attributes:
        joints: From base to output.
        simple: Whether they are a chain; else the limb has loops or branches of its own.
        freedoms: Basis of the twists it allows, (k, 6).
        constraints: Basis of the wrenches it imposes, (6 - k, 6).
    """

    joints: tuple[Joint, ...]
    simple: bool
    freedoms: Array
    constraints: Array


def link_freedoms(part: Arrangement, twists: Twists) -> LinkFreedoms:
    """Twists of all links reciprocal to all joints' wrenches.

    Args:
        part: The links and joints.
        twists: Present twists of every joint, by name, in a gauge, (f, 6).
    """
    moving = {link: number for number, link in enumerate(_moving(part))}
    rows = list[Array]()
    for joint in part.joints:
        wrenches = reciprocal(twists[joint.name])
        block = np.zeros((len(wrenches), 6 * len(moving)))
        for link, sign in zip(joint.links, (-1.0, 1.0), strict=True):
            if link in moving:
                block[:, 6 * moving[link] : 6 * moving[link] + 6] = sign * wrenches
        rows.append(block)
    constraints = np.concatenate(rows)
    motions = null_space(constraints)
    start = 6 * moving[part.output]
    rank = 6 * len(moving) - len(motions)
    return LinkFreedoms(len(motions), len(constraints) - rank, row_space(motions[:, start : start + 6]))


def platform_freedoms(part: Arrangement, twists: Twists) -> Array:
    """Basis (k, 6) of the output's twists: limbs in parallel, stages in series, links where neither applies."""
    return joined(*(_stage_freedoms(stage, twists) for stage in stages(part)))


def limbs_of(part: Arrangement, twists: Twists) -> list[list[Limb]]:
    """The limbs of every stage with what each allows and imposes."""
    return [[_limb(limb, twists) for limb in limbs(stage)] for stage in stages(part)]


def _limb(limb: Arrangement, twists: Twists) -> Limb:
    chain = in_series(limb)
    freedoms = _limb_freedoms(limb, twists)
    return Limb(tuple(chain or limb.joints), chain is not None, freedoms, reciprocal(freedoms))


def _stage_freedoms(stage: Arrangement, twists: Twists) -> Array:
    pieces = limbs(stage)
    alone = len(pieces) == 1
    return _limb_freedoms(pieces[0], twists) if alone else met(*(_limb_freedoms(piece, twists) for piece in pieces))


def _limb_freedoms(limb: Arrangement, twists: Twists) -> Array:
    chain = in_series(limb)
    if chain is not None:
        return joined(*(twists[joint.name] for joint in chain))
    if len(stages(limb)) > 1:
        return platform_freedoms(limb, twists)
    return link_freedoms(limb, twists).output


def _moving(part: Arrangement) -> list[str]:
    return [link for link in links_of(part.joints) if link != part.base]
