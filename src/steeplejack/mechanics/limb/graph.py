"""The graph of a linkage: a spanning tree from the base, stages in series, limbs in parallel."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from steeplejack.mechanics.limb.linkage import Joint, Linkage


class Arrangement(NamedTuple):
    """A connected part of a linkage between two of its links.

    Attributes:
        base: The link its motion is relative to.
        output: The link whose motion is asked for.
        joints: All joints of the part.
    """

    base: str
    output: str
    joints: tuple[Joint, ...]


def whole(linkage: Linkage) -> Arrangement:
    """All of a linkage."""
    return Arrangement(linkage.base, linkage.output, linkage.joints)


def links_of(joints: Iterable[Joint]) -> list[str]:
    """Names of the links that joints connect, each once, in their order."""
    return list(dict.fromkeys(link for joint in joints for link in joint.links))


def spanning_tree(part: Arrangement) -> tuple[list[tuple[Joint, str]], list[Joint]]:
    """Breadth-first tree from the base.

    Returns:
        Joints of the tree, each with the link it reaches, in the order they are reached; and the joints that close
        loops: as many as there are independent loops.
    """
    reached, tree, rest, grown = {part.base}, list[tuple[Joint, str]](), list(part.joints), True
    while grown:
        level = set(reached)
        for joint in rest:
            one, other = joint.links
            if (one in level) != (other in level):
                new = other if one in level else one
                if new not in reached:
                    tree.append((joint, new))
                    reached.add(new)
        grown = len(reached) > len(level)
    used = {joint.name for joint, _link in tree}
    return tree, [joint for joint in rest if joint.name not in used]


def stages(part: Arrangement) -> list[Arrangement]:
    """Parts in series from base to output: the linkage cut at every link that all ways between the two pass through.

    Branches that hang on the output lead nowhere and are left out.
    """
    between = [link for link in links_of(part.joints) if link not in (part.base, part.output)]
    cuts = [link for link in between if part.output not in _reach(part.joints, part.base, {link})]
    # A later cut is not reached when an earlier one is taken out, so counting what is lost orders them.
    cuts.sort(key=lambda link: len(_reach(part.joints, part.base, {link})))
    ends = [part.base, *cuts, part.output]
    found = list[Arrangement]()
    for base, output in zip(ends, ends[1:], strict=False):
        inside = _reach(part.joints, base, {output}) | {output}
        taken = {joint.name for stage in found for joint in stage.joints}
        joints = [j for j in part.joints if set(j.links) <= inside and j.name not in taken]
        found.append(Arrangement(base, output, tuple(joints)))
    return found


def limbs(stage: Arrangement) -> list[Arrangement]:
    """Parts in parallel between base and output: the pieces left when both are taken out, and every direct joint."""
    ends = {stage.base, stage.output}
    rest, found = list(stage.joints), list[Arrangement]()
    while rest:
        first = rest[0]
        inner = set(first.links) - ends
        links = _reach(rest, next(iter(inner)), ends) if inner else set[str]()
        piece = [joint for joint in rest if set(joint.links) & links] if inner else [first]
        rest = [joint for joint in rest if joint not in piece]
        if ends <= set(links_of(piece)):
            found.append(Arrangement(stage.base, stage.output, tuple(piece)))
    return found


def in_series(limb: Arrangement) -> Sequence[Joint] | None:
    """The joints of a simple chain from base to output in their order; None if the part is not a simple chain."""
    chain, link, rest = list[Joint](), limb.base, list(limb.joints)
    while link != limb.output:
        onward = [joint for joint in rest if link in joint.links]
        if len(onward) != 1:
            return None
        chain.append(onward[0])
        rest.remove(onward[0])
        link = next(end for end in onward[0].links if end != link)
    return None if rest else chain


def _reach(joints: Iterable[Joint], start: str, without: set[str]) -> set[str]:
    """Links that can be reached from one of them without passing through some."""
    neighbours = dict[str, list[str]]()
    for one, other in (joint.links for joint in joints if not without & set(joint.links)):
        neighbours.setdefault(one, []).append(other)
        neighbours.setdefault(other, []).append(one)
    reached, front = {start}, [start]
    while front:
        new = [link for link in neighbours.get(front.pop(), []) if link not in reached]
        reached.update(new)
        front += new
    return reached
