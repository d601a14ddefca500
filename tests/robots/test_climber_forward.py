"""Forward kinematics: all real solutions, their number proved, modes, singular lengths, and a second method."""

from __future__ import annotations

import math

import numpy as np
import pytest
from climber_cases import LAYOUTS, REFERENCE, Array, anywhere, layout, named, poses, radians

from steeplejack.errors import InputError
from steeplejack.robots.pipe_climber import Layout
from steeplejack.robots.pipe_climber.certificate import certified_poses
from steeplejack.robots.pipe_climber.forward import ForwardStatus, forward_kinematics, home_determinant
from steeplejack.robots.pipe_climber.inverse import limb_lengths
from steeplejack.robots.pipe_climber.jacobian import jacobian
from steeplejack.robots.pipe_climber.modes import MODES
from steeplejack.robots.pipe_climber.singularity import singular_x


def apart(found: Array, pose: Array) -> Array:
    """Distances of poses from one, alpha modulo a turn."""
    difference = found - pose
    difference[..., 2] = np.angle(np.exp(1j * difference[..., 2]))
    return np.abs(difference).max(axis=-1)


def test_the_reference_solutions() -> None:
    case = REFERENCE["forward"]
    found = forward_kinematics(layout(), limb_lengths(layout(), radians(case["pose"])))
    upper = np.array([radians(pose) for pose in case["solutions"]])
    mirrored = upper * [1.0, -1.0, -1.0]
    assert found.poses == pytest.approx(np.concatenate((upper, mirrored)), abs=2e-7)
    assert (found.status, found.count) == (ForwardStatus.FOUR, 4)


@pytest.mark.parametrize("mechanism", LAYOUTS, ids=named)
def test_lengths_of_a_pose_give_it_back(mechanism: Layout, rng: np.random.Generator) -> None:
    given = anywhere(rng, 2000)
    lengths = limb_lengths(mechanism, given)
    found = forward_kinematics(mechanism, lengths)
    assert set(np.unique(found.count)) == {4}
    assert limb_lengths(mechanism, found.poses) == pytest.approx(lengths[:, None] * np.ones((1, 4, 1)), abs=1e-14)
    assert np.median(apart(found.poses, given[:, None]).min(axis=1)) < 1e-14
    assert apart(found.poses, given[:, None]).min(axis=1).max() < 1e-7  # beside a singular pose


@pytest.mark.parametrize("mechanism", LAYOUTS, ids=named)
def test_each_mode_has_its_signs(mechanism: Layout, rng: np.random.Generator) -> None:
    found = forward_kinematics(mechanism, limb_lengths(mechanism, anywhere(rng, 500))).poses
    side, sense = np.sign(found[..., 1]), np.sign(np.linalg.det(jacobian(mechanism, found)))
    home = -np.sign(home_determinant(mechanism))
    assert (side == [1, 1, -1, -1]).all()
    assert (sense == home * np.array([1, -1, 1, -1])).all()


def test_counts_are_0_or_4_on_100_000_random_triples(rng: np.random.Generator) -> None:
    for mechanism in LAYOUTS[:4]:
        found = forward_kinematics(mechanism, rng.uniform(0.02, 0.4, (25_000, 3)))
        assert set(np.unique(found.count)) == {0, 4}
        assert (found.count == found.status).all()


@pytest.mark.parametrize("mechanism", LAYOUTS[:6:5], ids=named)
def test_counts_and_poses_are_the_certified_ones(mechanism: Layout, rng: np.random.Generator) -> None:
    lengths = rng.uniform(0.05, 0.3, (300, 3))
    found = forward_kinematics(mechanism, lengths)
    for triple, poses_, count in zip(lengths, found.poses, found.count, strict=True):
        proved = certified_poses(mechanism, triple.tolist())
        assert len(proved) == count
        if proved:
            assert tuple(one.mode for one in proved) == MODES
            assert max(one.error for one in proved) < 1e-15
            assert apart(np.array([one.pose for one in proved]), poses_).max() < 1e-9


def newton(mechanism: Layout, lengths: Array, starts: Array) -> list[Array]:
    """Distinct poses that Newton's method finds from many starts at once."""
    pose = starts.copy()
    with np.errstate(all="ignore"):
        for _ in range(40):
            rows = jacobian(mechanism, pose)
            good = np.isfinite(rows).all(axis=(1, 2)) & (np.abs(np.linalg.det(np.nan_to_num(rows))) > 1e-12)
            pose, rows = pose[good], rows[good]
            step = np.linalg.solve(rows, (limb_lengths(mechanism, pose) - lengths)[..., None])[..., 0]
            pose = pose - step * np.minimum(1.0, 0.1 / np.abs(step).max(axis=1, keepdims=True))
    pose = pose[np.abs(limb_lengths(mechanism, pose) - lengths).max(axis=1) < 1e-12]
    distinct: list[Array] = []
    for one in pose:
        if not distinct or apart(np.array(distinct), one).min() > 1e-6:
            distinct.append(one)
    return distinct


def same_sets(mechanism: Layout, lengths: Array, starts: Array) -> int:
    """How many triples of lengths have poses; Newton's method from every start has to find these and no others."""
    found = forward_kinematics(mechanism, lengths)
    for triple, poses_, count in zip(lengths, found.poses, found.count, strict=True):
        by_newton = newton(mechanism, triple, starts)
        assert len(by_newton) == count
        for one in by_newton:
            assert apart(poses_, one).min() < 1e-9
    return int((found.count > 0).sum())


@pytest.mark.long
def test_multistart_newton_finds_the_same_sets_on_1_000_random_triples(rng: np.random.Generator) -> None:
    starts = rng.uniform([-0.3, -0.3, -math.pi], [0.3, 0.3, math.pi], (150, 3))
    assert 300 < same_sets(layout(), rng.uniform(0.08, 0.3, (1000, 3)), starts) < 900


@pytest.mark.parametrize("mechanism", LAYOUTS[1:], ids=named)
def test_multistart_newton_finds_the_same_sets(mechanism: Layout, rng: np.random.Generator) -> None:
    starts = rng.uniform([-0.3, -0.3, -math.pi], [0.3, 0.3, math.pi], (300, 3))
    assert same_sets(mechanism, rng.uniform(0.08, 0.3, (20, 3)), starts) > 2


def test_the_home_pose_and_its_own_half_turn(rng: np.random.Generator) -> None:
    """At 0 and at 180 deg, where Eq. 12 of the paper divides 0 by 0."""
    mechanism = layout()
    for x, w in rng.uniform([-0.08, 0.1], [0.08, 0.22], (50, 2)):
        for alpha in (0.0, math.pi):
            pose = np.array([x, w, alpha])
            lengths = limb_lengths(mechanism, pose)
            found = forward_kinematics(mechanism, lengths)
            assert apart(found.poses, pose).min() < 1e-13
            assert apart(found.poses, pose * [1.0, -1.0, -1.0]).min() < 1e-13
            assert len(certified_poses(mechanism, lengths.tolist())) == 4


def test_tiny_angles_come_back_whole(rng: np.random.Generator) -> None:
    given = np.stack((np.full(60, 0.02), np.full(60, 0.15), 10.0 ** np.linspace(-16.0, -1.0, 60)), axis=-1)
    found = forward_kinematics(layout(), limb_lengths(layout(), given)).of("home")
    assert found == pytest.approx(given, abs=5e-15)


def test_near_the_singular_surface_the_answer_is_honest(rng: np.random.Generator) -> None:
    """Two pairs merge: the poses get close and less certain, the lengths stay exact, the count stays 0 or 4."""
    mechanism, alpha, w = layout(), -0.9, 0.15
    x = float(singular_x(mechanism, w, alpha))
    away = 10.0 ** -np.arange(2.0, 9.0)
    given = np.stack((x + away, np.full(7, w), np.full(7, alpha)), axis=-1)
    lengths = limb_lengths(mechanism, given)
    found = forward_kinematics(mechanism, lengths)
    for pose, triple, poses_, status in zip(given, lengths, found.poses, found.status, strict=True):
        proved = certified_poses(mechanism, triple.tolist())
        assert len(proved) in (0, 4)
        if status != ForwardStatus.UNDECIDED:
            assert np.isfinite(poses_[:, 0]).sum() == len(proved)
            assert apart(poses_, pose).min() < 1e-14 / abs(pose[0] - x)
        if np.isfinite(poses_).all():
            assert limb_lengths(mechanism, poses_) == pytest.approx(np.tile(triple, (4, 1)), abs=1e-14)
    gaps = apart(found.poses[:, 0], found.poses[:, 1])
    assert (np.diff(gaps[:5]) < 0.0).all()


def test_on_the_surface_the_status_says_undecided_and_the_proof_decides() -> None:
    """All hinges on one line, in binary fractions: a double root at alpha = 0 exactly."""
    mechanism = Layout((1.0, 1.0, 0.75, 0.75))
    assert forward_kinematics(mechanism, [1.25, 2.75, 2.0]).status == ForwardStatus.UNDECIDED
    (only,) = certified_poses(mechanism, [1.25, 2.75, 2.0])
    assert (only.pose, only.mode, only.multiplicity) == ((2.0, 0.0, 0.0), "singular", 2)


def test_lengths_out_of_reach_have_no_pose_and_are_no_error() -> None:
    found = forward_kinematics(layout(), [[0.1, 0.2, 0.9], [0.15, 0.15, 0.15]])
    assert found.status[0] == ForwardStatus.NONE
    assert np.isnan(found.poses[0]).all()
    assert certified_poses(layout(), [0.1, 0.2, 0.9]) == []


def test_one_bad_row_does_not_stop_the_others() -> None:
    good = limb_lengths(layout(), [0.0, 0.16, 0.0])
    found = forward_kinematics(layout(), [good, [math.nan, 0.1, 0.1], [-0.1, 0.1, 0.1], [math.inf, 0.1, 0.1]])
    assert found.status.tolist() == [4, -2, -2, -2]
    assert forward_kinematics(layout(), np.empty((0, 3))).poses.shape == (0, 4, 3)


def test_solutions_scale_with_the_machine(rng: np.random.Generator) -> None:
    given = poses(rng, 100)
    small = forward_kinematics(layout(), limb_lengths(layout(), given)).poses
    for scale in (1e-6, 1e6):
        large = Layout(tuple(scale * length for length in layout().lengths))  # pyright: ignore
        found = forward_kinematics(large, scale * limb_lengths(layout(), given)).poses
        assert found / [scale, scale, 1.0] == pytest.approx(small, abs=1e-10)


def test_a_mechanism_of_similar_platforms_is_refused() -> None:
    with pytest.raises(InputError, match="unlike proportions"):
        forward_kinematics(Layout((0.05, 0.1, 0.1, 0.2)), [0.1, 0.1, 0.1])
    with pytest.raises(InputError, match="unlike proportions"):
        certified_poses(Layout((0.0625, 0.125, 0.125, 0.25)), [0.1, 0.1, 0.1])
    with pytest.raises(InputError, match="three finite lengths"):
        certified_poses(layout(), [0.1, math.nan, 0.1])
    rounded = Layout((0.1, 0.1, 0.2, 0.2 * (1.0 + 1e-10)))
    for ask in (forward_kinematics, certified_poses):
        with pytest.raises(InputError, match="unlike proportions"):
            ask(rounded, [0.1, 0.1, 0.1])
    assert forward_kinematics(Layout((0.1, 0.1, 0.2, 0.2 * (1.0 + 1e-7))), [0.1, 0.1, 0.1]).status.size == 1


def test_the_kernel_never_claims_what_the_proof_denies(rng: np.random.Generator) -> None:
    """Dimensions over three decades, poses far away and down to 1e-16 of the singular surface."""
    decided = 0
    for turn in range(8):
        mechanism = Layout(tuple(10.0 ** rng.uniform(-3.0, 0.0, 4)), ("text", "equations")[turn % 2])  # pyright: ignore
        unit = max(mechanism.lengths)
        w, alpha = rng.uniform(-2.0 * unit, 2.0 * unit, 30), rng.uniform(-math.pi, math.pi, 30)
        x = singular_x(mechanism, w, alpha) + unit * rng.choice([-1.0, 1.0], 30) * 10.0 ** rng.uniform(-16.0, -1.0, 30)
        lengths = limb_lengths(mechanism, np.stack((x, w, alpha), axis=-1))
        found = forward_kinematics(mechanism, lengths)
        for triple, status in zip(lengths, found.status, strict=True):
            if status != ForwardStatus.UNDECIDED:
                assert len(certified_poses(mechanism, triple.tolist())) == status
                decided += 1
    assert decided > 60
