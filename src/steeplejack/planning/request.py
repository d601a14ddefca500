"""What to inspect when the user leaves it open: a bay that fits, and a stretch that can be held."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from steeplejack.errors import InfeasibleError, InputError
from steeplejack.planning.certificate import Rules, Scene
from steeplejack.planning.compatibility import Verdict, check
from steeplejack.planning.inspection import held_fraction
from steeplejack.robots.squad.bay import Bay
from steeplejack.robots.squad.parameters import Squad
from steeplejack.worksite import Bridge, Fan, Stay
from steeplejack.worksite.chord import Point

SHAPE = ("weight", "tension")  # data without which a stay's sag is not known
USUAL = (5, 9)  # the bay tried first
ABOUT = 100.0  # [m] of interior stay inspected when nothing is asked for
STARTS = (20.0, 30.0, 40.0, 15.0, 50.0, 60.0, 80.0)  # [m] where such a stretch may begin, in the order tried


def verdicts(bridge: Bridge, squad: Squad) -> tuple[Verdict, ...]:
    """The verdict on every stay of a bridge."""
    return tuple(check(stay, squad, bridge.gravity) for fan in bridge.fans.values() for stay in fan.stays)


def choose_bay(
    bridge: Bridge, squad: Squad, fan: str | None, stays: tuple[int, int] | None, accept_unknown: bool
) -> tuple[Fan, tuple[int, int], tuple[str, ...]]:
    """A fan and its boundary stays, as asked or the first that fits; and what was assumed about its stays.

    Args:
        bridge: Its stays may hang as catenaries or, where that was asked for, on their chords.
        squad: The machine.
        fan: Name of the fan, or None for any.
        stays: Numbers of the boundary stays, or None for any.
        accept_unknown: Whether unknown data may be assumed.

    Raises:
        InputError: No such fan or stays; or data are unknown and were not accepted.
        InfeasibleError: Stays that do not fit the machine; the first reason binds.
    """
    refusals: list[Verdict] = []
    lacking: list[Verdict] = []
    for each in _fans(bridge, fan, stays):
        for first, last in [stays] if stays else _bays(each):
            within = each.between(first, last)
            found = [_verdict(stay, squad, bridge.gravity) for stay in within]
            bad = [verdict for verdict in found if verdict.fits is False]
            open_ = [verdict for verdict in found if verdict.fits is None]
            refusals += bad
            if bad:
                continue
            if open_ and not accept_unknown:
                lacking += open_
                continue
            return each, (first, last), _assumed(within, open_, squad)
    if lacking:
        raise _too_little_known(lacking[0])
    why = f"stay {refusals[0].stay}: {refusals[0].reasons[0]}" if refusals else "no fan has three stays in a row"
    raise InfeasibleError(f"no bay of {bridge.name} fits {squad.name}", why)


def _fans(bridge: Bridge, fan: str | None, stays: tuple[int, int] | None) -> list[Fan]:
    """Fans to look in: the one asked for, or all that have the stays asked for and one between.

    Raises:
        InputError: There is none.
    """
    fans = [bridge.fan(fan)] if fan else list(bridge.fans.values())
    if stays is None:
        return fans
    first, last = stays
    having = fans if fan else [each for each in fans if {first, last} <= {stay.index for stay in each.stays}]
    if not having:
        numbers = ", ".join(f"{each.id} {each.stays[0].index}-{each.stays[-1].index}" for each in fans)
        raise InputError("--stays", f"no fan of {bridge.name} has both {first} and {last}", f"numbers of {numbers}")
    wide = [each for each in having if len(each.between(first, last)) > 2]
    if not wide:
        raise InputError("--stays", f"{first}:{last} has no interior stay", "boundary stays at least two apart")
    return wide


def _verdict(stay: Stay, squad: Squad, gravity: Point) -> Verdict:
    """The verdict on a stay that is to be flown along: what shapes its curve must be known as well."""
    verdict = check(stay, squad, gravity)
    shape = tuple(name for name in stay.unknown if name in SHAPE)
    return replace(verdict, unknown=(*verdict.unknown, *shape))


def _too_little_known(verdict: Verdict) -> InputError:
    chord = "--chord to take straight stays, " if set(verdict.unknown) <= set(SHAPE) else ""
    return InputError(
        f"stay {verdict.stay}",
        ", ".join(f"{name} unknown" for name in verdict.unknown),
        f"the missing data, {chord}or --accept-unknown to assume what is missing",
    )


def _assumed(stays: tuple[Stay, ...], open_: list[Verdict], squad: Squad) -> tuple[str, ...]:
    """In words, what takes the place of the data these stays lack, and of their sag where the chord was asked for."""
    lacking = sorted({name for verdict in open_ for name in verdict.unknown})
    straight = any(stay.chord_only for stay in stays)
    words = [f"{name}: {_instead(name, squad)}" for name in lacking]
    return (*words, *(("shape: straight chords, as asked for",) if straight else ()))


def _instead(name: str, squad: Squad) -> str:
    if name == "diameter":
        return f"the machine's largest, {1e3 * squad.base.stay_diameter[1]:.0f} mm"
    return "unknown, so stays without it are straight chords" if name in SHAPE else "unknown, so no base passes it"


def _bays(fan: Fan) -> list[tuple[int, int]]:
    """Bays of a fan, the usual one first, then five stays at a time, then fewer."""
    indices = [stay.index for stay in fan.stays]
    wide = [(indices[i], indices[i + n]) for n in (4, 3, 2) for i in range(len(indices) - n)]
    return sorted(wide, key=lambda bay: bay != USUAL)


def asked_stretch(bay: Bay, from_m: float | None, to_m: float | None) -> tuple[float, float] | None:
    """The stretch of the interior stays asked for [m], about 100 m in all where one end is given; None where neither.

    Raises:
        InputError: Outside the stays or upside down.
    """
    if from_m is None and to_m is None:
        return None
    reach, each = bay.reach, ABOUT / len(bay.interior)
    low = from_m if from_m is not None else max(0.0, (to_m or 0.0) - each)
    high = to_m if to_m is not None else min(reach, low + each)
    for name, value in (("--from-m", low), ("--to-m", high)):
        if not 0.0 <= value <= reach:
            raise InputError(name, f"{value:g} m", f"0 to {reach:.1f} m, the length of the bay's shortest stay")
    if high - low < 1.0:
        raise InputError("--from-m, --to-m", f"{low:g} to {high:g} m", "a stretch of at least 1 m")
    return low, high


def choose_stretch(bridge: Bridge, bay: Bay, squad: Squad, rules: Rules) -> tuple[float, float]:
    """Where along the interior stays to inspect [m]: about 100 m in all, the first that stances hold most of."""
    reach, each = bay.reach, ABOUT / len(bay.interior)
    scene = Scene.of(bay, squad, rules, np.array(bridge.gravity))
    options = [(start, min(start + each, reach)) for start in STARTS if start + 0.5 * each < reach]
    best = (-1.0, (0.0, min(each, reach)))
    for option in options:
        share = held_fraction(scene, *option)
        if share > best[0] + 1e-9:
            best = share, option
        if share > 0.999:
            break
    return best[1]
