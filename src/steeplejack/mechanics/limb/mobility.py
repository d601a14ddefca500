"""Mobility of any linkage by three routes, in one place and beyond it.

By reciprocal screws: link twists reciprocal to all joints' constraint wrenches, and for the output the union of its
limbs' constraint systems. By loop closure: the null space of the full constraint Jacobian, passive freedoms included.
By the modified Kutzbach-Gruebler formula, ``M = d (n - g - 1) + sum f + v`` (Huang, Li and Ding, Theory of Parallel
Mechanisms, 2013, ch. 3; Eq. 4 of Ye et al.), with the order ``d`` and the redundant constraints ``v`` found from the
screws.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from steeplejack.mechanics.limb.closure import Closure
from steeplejack.mechanics.limb.excursion import Excursion, excursions
from steeplejack.mechanics.limb.graph import Arrangement, links_of, whole
from steeplejack.mechanics.limb.linkage import LETTERS, Joint, Linkage
from steeplejack.mechanics.limb.names import constraints_in_words, freedoms_in_words
from steeplejack.mechanics.limb.reciprocity import LinkFreedoms, limbs_of, link_freedoms, platform_freedoms
from steeplejack.mechanics.limb.systems import Gauge, least_kept, null_space, order, reciprocal, row_space, same

Array = NDArray[np.float64]

Kind = Literal["full cycle", "singular reference", "instantaneous", "structure"]


@dataclass(frozen=True)
class Kutzbach:
    """The terms of the modified Kutzbach-Gruebler formula.

    Attributes:
        order: ``d``: 6 less the constraints common to all joints.
        links: ``n``, the fixed one included.
        joints: ``g``.
        freedoms: ``sum f`` over the joints.
        redundant: ``v``: constraints that are dependent beyond the common ones, from the states of self-stress.
    """

    order: int
    links: int
    joints: int
    freedoms: int
    redundant: int

    @property
    def mobility(self) -> int:
        """``M``."""
        return self.order * (self.links - self.joints - 1) + self.freedoms + self.redundant


@dataclass(frozen=True)
class LimbReport:
    """A limb in words.

    Attributes:
        joints: Letters of its joints from base to output; of a limb with loops, in the order of the file.
        simple: Whether it is a chain without loops.
        connectivity: Freedoms of the output on this limb alone.
        constraints: What it imposes on the output.
    """

    joints: str
    simple: bool
    connectivity: int
    constraints: list[str]


@dataclass(frozen=True)
class Mobility:
    """What a linkage can do.

    Attributes:
        by_reciprocal_screws: Mobility by constraint wrenches, in the reference configuration.
        by_closure: Mobility by the rank of the loop equations, there.
        kutzbach: The modified Kutzbach-Gruebler formula, there.
        beyond: Mobility at configurations reached by finite motion; empty if none can be reached.
        mobility: That of the full cycle: the largest of ``beyond``, 0 if there is none.
        kind: ``full cycle``: the same in the reference and beyond; ``singular reference``: more freedoms in the
            reference than beyond; ``instantaneous``: freedoms in the reference alone; ``structure``: none.
        twists: Basis of the output's freedoms in the reference, at the base's frame, SI, (k, 6).
        wrenches: Basis of the constraints on the output, likewise, (6 - k, 6).
        freedoms: Those freedoms in words.
        constraints: Those constraints in words.
        common: Constraints common to all joints, in words.
        passive: Freedoms that leave the output at rest.
        locked: Mobility left when every actuated joint is held; None without actuated joints.
        limbs: Of every stage between base and output.
        least_kept: Smallest singular value of the loop equations that counts towards their rank, lengths in units of
            the characteristic one [1]; near `RANK` the reference is next to a singular configuration.
        agree: Whether all routes found the same mobility and the same freedoms of the output.
    """

    by_reciprocal_screws: int
    by_closure: int
    kutzbach: Kutzbach
    beyond: tuple[int, ...]
    mobility: int
    kind: Kind
    twists: Array
    wrenches: Array
    freedoms: list[str]
    constraints: list[str]
    common: list[str]
    passive: int
    locked: int | None
    limbs: list[list[LimbReport]]
    least_kept: float
    agree: bool


def mobility(linkage: Linkage, rng: np.random.Generator | None = None) -> Mobility:
    """Count and name the freedoms of a linkage.

    Args:
        linkage: Links and joints in a closed reference configuration.
        rng: Directions of the walks that tell full-cycle from instantaneous mobility; the same ones by default.

    Returns:
        Counts by every route with the freedoms of the output.
    """
    part, gauge = whole(linkage), gauge_of(linkage)
    closure = Closure.of(part, gauge)
    reference = closure.at(np.zeros(closure.freedoms))
    motions = null_space(reference.jacobian)
    output = row_space(motions @ reference.output.T)
    links, platform = link_freedoms(part, closure.twists), platform_freedoms(part, closure.twists)
    screws = np.concatenate(list(closure.twists.values()))
    formula = _kutzbach(part, links, order(screws))
    counts = (links.mobility, len(motions), formula.mobility)
    reached = excursions(closure, np.random.default_rng(0) if rng is None else rng)
    lasting = max((excursion.lasting for excursion in reached), default=0)
    return Mobility(
        by_reciprocal_screws=links.mobility,
        by_closure=len(motions),
        kutzbach=formula,
        beyond=tuple(excursion.lasting for excursion in reached),
        mobility=lasting,
        kind=_kind(len(motions), reached, lasting),
        twists=gauge.plain_twists(output),
        wrenches=gauge.plain_wrenches(reciprocal(output)),
        freedoms=freedoms_in_words(output, gauge),
        constraints=constraints_in_words(reciprocal(output), gauge),
        common=constraints_in_words(reciprocal(screws), gauge),
        passive=len(motions) - len(output),
        locked=_locked(linkage, closure, reference.jacobian),
        limbs=_limb_reports(part, closure, gauge),
        least_kept=least_kept(reference.jacobian),
        agree=len(set(counts)) == 1 and same(output, platform) and same(output, links.output),
    )


def gauge_of(linkage: Linkage) -> Gauge:
    """Where lengths of a linkage are measured from, and in what unit: the points of its joints."""
    return Gauge.of([joint.point for joint in linkage.joints if joint.point is not None])


def _kutzbach(part: Arrangement, links: LinkFreedoms, common_order: int) -> Kutzbach:
    """The formula's terms: of all states of self-stress, 6 - d a loop are due to the constraints common to all."""
    count, joints = len(links_of(part.joints)), len(part.joints)
    loops = joints - count + 1
    return Kutzbach(
        order=common_order,
        links=count,
        joints=joints,
        freedoms=sum(joint.freedoms for joint in part.joints),
        redundant=links.self_stress - (6 - common_order) * loops,
    )


def _kind(here: int, reached: list[Excursion], lasting: int) -> Kind:
    if here == 0:
        return "structure"
    if not reached or lasting == 0:
        return "instantaneous"
    return "full cycle" if lasting == here else "singular reference"


def _locked(linkage: Linkage, closure: Closure, jacobian: Array) -> int | None:
    """Mobility left with every actuated joint held."""
    free = np.ones(closure.freedoms, dtype=bool)
    for joint in linkage.joints:
        if joint.actuated:
            free[closure.columns[joint.name]] = False
    return None if free.all() else len(null_space(jacobian[:, free]))


def _limb_reports(part: Arrangement, closure: Closure, gauge: Gauge) -> list[list[LimbReport]]:
    return [
        [
            LimbReport(
                _letters(limb.joints), limb.simple, len(limb.freedoms), constraints_in_words(limb.constraints, gauge)
            )
            for limb in stage
        ]
        for stage in limbs_of(part, closure.twists)
    ]


def _letters(joints: tuple[Joint, ...]) -> str:
    return "".join(LETTERS[joint.kind] for joint in joints)
