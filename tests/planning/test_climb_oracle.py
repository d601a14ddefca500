"""The oracle of climbs held against MuJoCo, HiGHS and brute force, and the planner's rules against the oracle's."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import product

import numpy as np
import oracle_bends
import pytest
from climb_cases import ROBOT, random_run
from oracle_audit import disagreements
from oracle_bars import Sector, Solid, Tube, met, solids_of
from oracle_bodies import BEAM, ORDER, UPPER, Bodies, gap_to_axis
from oracle_clearance import footing, passes
from oracle_grips import Pads, by_highs, facets, used
from oracle_loads import loads
from oracle_rules import Rules
from scipy.spatial.transform import Rotation

from steeplejack.planning.climb import places
from steeplejack.planning.climb.frames import touching, worst_uses
from steeplejack.planning.climb.limits import Machine
from steeplejack.planning.climb.plan import Hold
from steeplejack.planning.climb.solids import AIR, obstacles_of
from steeplejack.robots.pipe_climber import Layout
from steeplejack.robots.pipe_climber.pads import BOTH, FIRST, LAST
from steeplejack.simulation.climber.scene import build
from steeplejack.simulation.engine import mujoco
from steeplejack.worksite.pipe_builtin import load_pipe
from steeplejack.worksite.pipe_run import PipeRun, with_bends

BODIES, MACHINE = Bodies.of(ROBOT), Machine.of(ROBOT)
MODEL = build(ROBOT, Layout.of(ROBOT), [BEAM], np.zeros(3), (0.3, 0.3))
DATA = mujoco.MjData(MODEL)
GRAVITY = np.array([2.0, -5.0, -8.0])


def drawn(rng: np.random.Generator, count: int) -> np.ndarray:
    columns = ((-0.02, 0.02), (0.15, 0.2), (-0.4, 0.4), (-0.5, 0.5))
    return np.column_stack([rng.uniform(low, high, count) for low, high in columns])


def coordinates(freedoms: np.ndarray, upper: bool) -> np.ndarray:
    """The engine's, with the lower or the upper gripper's frame that of the world."""
    beta = freedoms[3]
    theta = np.arctan2(*BODIES.limbs(freedoms[None, :3])[0].T)
    joints = {"G1": beta, "G2": beta, "G3": -beta, "G4": -beta, "plate": beta, "platform3": freedoms[2] - theta[2]}
    for limb, length in enumerate(BODIES.lengths(freedoms[None, :3])[0]):
        joints |= {f"base{limb + 1}": theta[limb], f"limb{limb + 1}": length}
    joints |= {f"{end}_{jaw}": BODIES.jaw for end in ("lower", "upper") for jaw in "ab"}
    found = np.zeros(MODEL.nq)
    for name, value in joints.items():
        found[MODEL.joint(name).qposadr] = value
    root = np.linalg.inv(BODIES.frames(freedoms[None])[0, UPPER]) if upper else np.eye(4)
    found[:3], found[3:7] = root[:3, 3], Rotation.from_matrix(root[:3, :3]).as_quat(scalar_first=True)
    return found


@pytest.mark.parametrize("upper", [False, True])
def test_bodies_and_bars_are_where_the_engine_puts_them(upper: bool, rng: np.random.Generator):
    order = [MODEL.body(name).id for name in ORDER]
    capsules = np.flatnonzero((MODEL.geom_type == mujoco.mjtGeom.mjGEOM_CAPSULE) & (MODEL.geom_bodyid > 0))
    for freedoms in drawn(rng, 5):
        DATA.qpos[:] = coordinates(freedoms, upper)
        mujoco.mj_fwdPosition(MODEL, DATA)
        assert np.abs(DATA.efc_pos[DATA.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY]).max() < 1e-9  # loops close
        frames = BODIES.frames(freedoms[None])[0]
        seen = np.linalg.inv(frames[UPPER]) if upper else np.eye(4)
        frames = seen @ frames
        np.testing.assert_allclose(frames[:, :3, 3], DATA.xpos[order], atol=1e-9)
        np.testing.assert_allclose(frames[:, :3, :3], DATA.xmat[order].reshape(-1, 3, 3), atol=1e-9)
        middles = BODIES.bars_at(freedoms[None])[0].mean(axis=1) @ seen[:3, :3].T + seen[:3, 3]
        np.testing.assert_allclose(middles, DATA.geom_xpos[capsules], atol=1e-9)


@pytest.mark.parametrize("upper", [False, True])
def test_loads_are_weight_and_momentum_of_the_engine(upper: bool, rng: np.random.Generator):
    """From rest the rate of momentum is the momentum that the accelerations, taken as speeds, would have."""
    step = 1e-6
    for freedoms, rates in zip(drawn(rng, 5), rng.normal(size=(5, 4)) * [0.5, 0.5, 4.0, 30.0], strict=True):
        weight, pushes = loads(BODIES, freedoms[None], GRAVITY[None], rates[None, None], upper)
        ends = [coordinates(freedoms + sign * step * rates, upper) for sign in (-1.0, 1.0)]
        DATA.qpos[:] = coordinates(freedoms, upper)
        mujoco.mj_differentiatePos(MODEL, DATA.qvel, 2.0 * step, *ends)
        mujoco.mj_fwdPosition(MODEL, DATA)
        mujoco.mj_comVel(MODEL, DATA)
        mujoco.mj_subtreeVel(MODEL, DATA)
        mass, middle, linear = MODEL.body_subtreemass[1], DATA.subtree_com[1], DATA.subtree_linvel[1]
        pull = BODIES.frames(freedoms[None])[0, UPPER, :3, :3].T @ GRAVITY if upper else GRAVITY
        np.testing.assert_allclose(weight[0], mass * np.append(np.cross(middle, pull), pull), atol=1e-9)
        momentum = np.append(DATA.subtree_angmom[1] + mass * np.cross(middle, linear), mass * linear)
        np.testing.assert_allclose(pushes[0, 0], -momentum, atol=1e-5)


@pytest.mark.parametrize(("radius", "rows"), [(0.03, BOTH), (0.025, FIRST), (0.04, LAST)])
def test_facets_give_what_a_linear_programme_gives(radius: float, rows: int, rng: np.random.Generator):
    pads, size = Pads.of(ROBOT), np.array([0.6, 0.6, 0.6, 10.0, 10.0, 10.0])
    weight, pushes = rng.normal(size=(6, 6)) * size, 0.3 * rng.normal(size=(6, 2, 6)) * size
    found, wrenches = used(facets(pads, radius, rows), weight, pushes), pads.wrenches(radius, rows)
    for k in range(6):
        tried = [weight[k] + np.array(signs) @ pushes[k] for signs in product((1.0, -1.0), repeat=2)]
        assert found[k] == pytest.approx(max(by_highs(wrenches, load) for load in tried), rel=1e-6)


@pytest.mark.parametrize(("radius", "rows"), [(0.03, BOTH), (0.025, FIRST)])
def test_on_a_straight_jaws_closed_pad_by_pad_give_the_facets(radius: float, rows: int, rng: np.random.Generator):
    pads, size = Pads.of(ROBOT), np.array([0.6, 0.6, 0.6, 10.0, 10.0, 10.0])
    pipe, s, clock = load_pipe("straight-vertical").pipes[0], np.array([0.4, 0.7]), np.array([0.3, -2.0])
    point, frames = pipe.centre_line(s)
    frames = frames @ Rotation.from_euler("z", clock[:, None]).as_matrix()
    weight, pushes = rng.normal(size=(2, 6)) * size, 0.3 * rng.normal(size=(2, 2, 6)) * size
    found = oracle_bends.used(oracle_bends.wrenches(pads, pipe, s, (point, frames), radius, rows), weight, pushes)
    np.testing.assert_allclose(found, used(facets(pads, radius, rows), weight, pushes), rtol=1e-6)


def surface(solid: Solid, rng: np.random.Generator) -> np.ndarray:
    """Points of a tube or of a sector, inside and on it."""
    count = 100_000
    share, out, clock = rng.random(count), np.sqrt(rng.random(count)), rng.uniform(-math.pi, math.pi, count)
    if isinstance(solid, Tube):
        points, frames = solid.part.at(solid.part.start + share * solid.part.length)
        out = np.where(rng.random(count) < 0.8, 1.0, out) * 0.5 * solid.part.diameter
    else:
        assert isinstance(solid, Sector)
        points = solid.point + (2.0 * share - 1.0)[:, None] * solid.half * solid.frame[:, 2]
        frames, out = np.broadcast_to(solid.frame, (count, 3, 3)), out * solid.outer
        clock = solid.middle + solid.spread * clock / math.pi
    across = np.cos(clock)[:, None] * frames[..., 0] + np.sin(clock)[:, None] * frames[..., 1]
    return points + out[:, None] * across


@pytest.mark.parametrize("name", ["bend-300", "clock-obstacle"])
def test_distances_are_those_of_the_nearest_point(name: str, rng: np.random.Generator):
    for solid in solids_of(load_pipe(name))[-2:]:
        points = surface(solid, rng)
        seen = points[rng.integers(len(points), size=30)] + rng.normal(0.0, 0.03, (30, 3))
        nearest = np.array([np.linalg.norm(points - one, axis=1).min() for one in seen])
        found = solid.distance(seen)
        assert (found <= nearest + 1e-9).all()
        assert (nearest - found)[found > 5e-3].max() < 2e-3  # as dense as the points are


def test_halving_bars_finds_what_points_along_them_find(rng: np.random.Generator):
    solids, radii = solids_of(load_pipe("clock-obstacle")), np.full(300, 0.008)
    bars = rng.uniform(-0.08, 0.08, (300, 1, 2, 3)) + np.array([0.0, 0.0, 0.35])
    share = np.linspace(0.0, 1.0, 801)[:, None]
    points = bars[:, 0, None, 0] * (1.0 - share) + bars[:, 0, None, 1] * share
    away = np.min([solid.distance(points.reshape(-1, 3)).reshape(300, -1).min(axis=1) for solid in solids], axis=0)
    clear = np.abs(away - 0.008 - AIR) > 5e-5
    hits = met(solids, bars, radii[:1], AIR)
    assert 50 < hits.sum() < 250
    np.testing.assert_array_equal(hits[clear], (away < 0.008 + AIR)[clear])


def test_on_a_straight_bars_keep_their_distance():
    assert gap_to_axis(BODIES) == pytest.approx(MACHINE.lowest_bar + AIR, abs=2e-4)


LUG = load_pipe("clock-obstacle")
HIGH = replace(LUG, name="high-lug", obstacles=(replace(LUG.obstacles[0], height=0.032),))  # in the linkage's way
CROWDED = [*(random_run(seed) for seed in (4, 13, 28)), load_pipe("planar-cross"), HIGH]
RUNS = [*CROWDED, load_pipe("reducer"), load_pipe("bend-300")]


TIGHT = replace(with_bends(load_pipe("bend-300"), 0.55), name="bend-165")  # grippers may close in some of it


@pytest.mark.parametrize("run", [*RUNS, TIGHT], ids=lambda run: run.name)
def test_planner_closes_stands_and_passes_where_the_oracle_does(run: PipeRun, rng: np.random.Generator):
    rules, pipe = Rules(run, ROBOT), run.pipes[0]
    edges = np.array([end for one in run.obstacles for end in (one.start, one.end)] + [one.end for one in pipe.parts])
    offsets = rng.choice([end for row in rules.jaws.rows for end in row], 2000) + rng.normal(0.0, 1e-4, 2000)
    s = np.append(rng.uniform(0.0, pipe.length, 4000), rng.choice(edges, 2000) + offsets)
    free = ~np.any([flags for _why, flags in places.trouble(run, MACHINE, pipe, s)], axis=0)
    np.testing.assert_array_equal(rules.closes(s), free)
    stands = np.stack(footing(ROBOT, pipe, s[free]), axis=-1)
    np.testing.assert_array_equal(stands, places.footing(MACHINE, pipe, s[free]))
    clocks, s = rng.uniform(-math.pi, math.pi, 40), s[::4]
    for spread in (0.0, 0.2):
        table = places.passes(run, MACHINE, pipe, s, clocks, spread)
        for clock, column in zip(clocks, table.T, strict=True):
            same = np.full(len(s), clock)
            passed = passes(rules.hindrances, ROBOT, (s, s), same, np.full(len(s), spread))
            np.testing.assert_array_equal(passed, column)


def standings(rules: Rules, rng: np.random.Generator, count: int) -> np.ndarray:
    """With poses that can be taken, in the plane of a bend and out of it, near what stands on the pipe."""
    pipe, limit = rules.pipe, ROBOT.rcm.limit
    near = np.append(rules.beside.mean(axis=1), [part.end for part in pipe.parts[:-1]])
    low = np.clip(rng.choice(near, count) - rng.uniform(-0.1, 0.3, count), 0.04, pipe.length - 0.3)
    bends = [part.toward for part in pipe.parts if not part.straight] or [0.0]
    aim = rng.choice(bends, count) + math.pi * rng.integers(0, 2, count)
    clock = np.where(rng.random(count) < 0.5, aim, rng.uniform(-math.pi, math.pi, count))
    found = np.column_stack(
        (low, low + rng.uniform(0.15, 0.2, count), clock + rng.uniform(-limit, limit, count), clock)
    )
    return found[rules.poses(found[:, :2], clock)[1]]


@pytest.mark.parametrize("run", CROWDED, ids=lambda run: run.name)
def test_planner_meets_what_the_oracle_meets(run: PipeRun, rng: np.random.Generator):
    """But for sagittas, and for what its cylindrical distances are out beside the edges of obstacles."""
    rules = Rules(run, ROBOT)
    some = standings(rules, rng, 3000)
    lowers = np.broadcast_to(np.eye(4), (len(some), 4, 4)).copy()
    lowers[:, :3, 3], lowers[:, :3, :3] = rules.lower_frames(some)
    freedoms = np.column_stack((rules.poses(some[:, :2], some[:, 3])[0], some[:, 3] - some[:, 2]))
    nearer, further = (
        touching(obstacles_of(run), MACHINE, lowers, freedoms, AIR + sign * 5e-4, True) for sign in (-1.0, 1.0)
    )
    found = rules.meets(some)
    assert found[nearer].all() and not found[~further].any()
    assert found.any() and not found.all()


@pytest.mark.parametrize("run", [*RUNS, TIGHT], ids=lambda run: run.name)
def test_planner_uses_grips_and_drives_as_the_oracle_does(run: PipeRun, rng: np.random.Generator):
    rules = Rules(run, ROBOT)
    some = standings(rules, rng, 400)
    some = some[rules.closes(some[:, 0]) & rules.closes(some[:, 1])]
    rules.use(some, rng.random(len(some)) < 0.5)
    assert len(some) > 20 and disagreements(rules, rng) == []


def test_replay_judges_grips_in_bends_as_the_oracle_does(rng: np.random.Generator):
    """Of the weight alone, for either gripper; where pads as on a straight would say something else."""
    run = load_pipe("bend-300")
    rules, name = Rules(run, ROBOT), run.pipes[0].name
    every = standings(rules, rng, 4000)
    every = every[rules.closes(every[:, 0]) & rules.closes(every[:, 1])]
    bend = next(part for part in rules.pipe.parts if not part.straight)
    for upper in (False, True):
        there = np.abs(every[:, int(upper)] - bend.start - 0.5 * bend.length) < 0.5 * bend.length
        some = every[there][:30]
        assert len(some) > 10
        freedoms, gravity, rates = rules.motions(some, upper)
        weight, pushes = loads(BODIES, freedoms, gravity, 0.0 * rates, upper)
        s, radius = some[:, int(upper)], 0.03
        corners = oracle_bends.wrenches(rules.pads, rules.pipe, s, rules.frames(some, upper), radius, BOTH)
        asked = oracle_bends.used(corners, weight, pushes) / (1.0 - ROBOT.gait.reserve)
        level = used(facets(rules.pads, radius, BOTH), weight, pushes) / (1.0 - ROBOT.gait.reserve)
        frames = np.broadcast_to(np.eye(4), (2, len(some), 4, 4)).copy()
        for end in range(2):
            frames[end, :, :3, 3], frames[end, :, :3, :3] = rules.frames(some, bool(end))
        for k, one in enumerate(some):
            places, hold = ((name, one[0]), (name, one[1])), Hold.UPPER if upper else Hold.LOWER
            both = (frames[0, k : k + 1], frames[1, k : k + 1])
            told = worst_uses(run, MACHINE, both, freedoms[k : k + 1], places, hold)[0]
            assert told == pytest.approx(asked[k], rel=5e-3)
        assert np.abs(level / asked - 1.0).max() > 0.06
