"""The climber's controller: cylinders and servo follow the reference, jaws do as told, grips are verified and watched.

A cylinder is told the reference's speed and what closes its length's error, ``v = v_ref + g (q_ref - q)``, within its
own. With both grippers on the pipe the mechanism is over-determined; cylinders then do not fight the pipe but give way
to what its grips add to the forces they should have, ``v = -y (f - f0)``: those they had before a gripper closed, and
before one opens those they will have when the other one bears the robot alone. A grip counts once its jaws press with
their force; from then on the pipe may not pass through it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from steeplejack.control.climber.jaws import open_place
from steeplejack.control.climber.signals import Array, Command, Flags, Measurement, Reference
from steeplejack.robots.pipe_climber import PipeClimber

GAIN = 25.0  # [1/s] of the lengths
TURN_GAIN = 8.0  # [1/s] of the linkage, whose servo counts coarsely
YIELD = 4e-4  # [m/s/N] of a cylinder between two closed grippers
HELD = 0.9  # share of its force with which a gripper counts as closed [1]; the sensor may be 5 % off
LOOSE = 0.2  # share of its force above which a gripper does not count as open [1]
SLIP = 5e-4  # [m] the pipe may pass through a closed gripper: pads give, and take up load, by less
LAG = 5e-3  # [m] a cylinder may lag behind


@dataclass(frozen=True)
class State:
    """What the controller remembers.

    Attributes:
        held: Grippers whose force has been verified since they were told to close (2,).
        mark: What had passed through each gripper when it was (2, 2) [m].
        load: Forces of the cylinders when last only one gripper was told to be closed (3,) [N].
    """

    held: Flags
    mark: Array
    load: Array


@dataclass(frozen=True)
class Status:
    """What the controller knows after a step.

    Attributes:
        held: Grippers whose force is verified (2,).
        slip: How far the pipe has passed through each since then (2,) [m]; 0 where it is open.
        slipping: Whether that is too far (2,).
        open: Grippers that stand clear of the pipe (2,).
        lag: Largest error of a limb's length [m].
        turn_lag: Error of the linkage's turn [rad].
        burden: By how much a cylinder's force misses what it should be [N]; 0 where it keeps to its length.
        lost: Whether a cylinder does not follow.
        readable: Whether the sensors gave numbers; if not, nothing else here is new.
    """

    held: Flags
    slip: Array
    slipping: NDArray[np.bool_]
    open: Flags
    lag: float
    turn_lag: float
    burden: float
    lost: bool
    readable: bool


class ClimberController:
    """From reference and measurement to command.

    Args:
        robot: The machine.
    """

    def __init__(self, robot: PipeClimber) -> None:
        self._robot = robot

    def begin(self, measured: Measurement) -> State:
        """The state before the first step."""
        return State(np.zeros(2, bool), measured.passed.copy(), measured.forces.copy())

    def step(
        self, state: State, reference: Reference, measured: Measurement, dt: float
    ) -> tuple[State, Command, Status]:
        """One control step.

        Args:
            state: After the step before.
            reference: Where the mechanism should be.
            measured: What the sensors say.
            dt: Time to the next step [s].

        Returns:
            The state, the command, and what is known; unreadable sensors give a command that closes both grippers.
        """
        opening = np.array([open_place(self._robot, float(radius)) for radius in reference.radius])
        if not measured.readable:
            nothing = np.zeros(2, bool)
            stop = Command(np.zeros(3), 0.0, np.ones(2, bool), opening)
            return state, stop, Status(nothing, np.zeros(2), nothing, nothing, np.inf, np.inf, np.inf, True, False)
        error = reference.lengths - measured.lengths
        braced = bool(reference.closed.all())
        giving = braced or reference.load is not None
        after, slip = self._grips(state, reference.closed, measured, state.load if braced else measured.forces)
        most, turn = self._robot.cylinders.speed, 0.0
        missing = (after.load if reference.load is None else reference.load) - measured.forces
        speeds, burden = np.clip(YIELD * missing, -most, most), float(np.abs(missing).max())
        if not giving:
            burden = 0.0
            speeds = np.clip(reference.rates + min(GAIN, 0.5 / dt) * error, -most, most)
            turn = reference.beta_rate + min(TURN_GAIN, 0.5 / dt) * (reference.beta - measured.beta)
        lag, turn_lag = float(np.abs(error).max()), abs(reference.beta - measured.beta)
        apart = measured.jaws >= opening - 0.2 * self._robot.build.jaw_clearance
        apart &= measured.grip <= LOOSE * self._robot.gripper.force
        lost = lag > LAG and not giving
        status = Status(after.held, slip, slip > SLIP, apart, lag, turn_lag, burden, lost, True)
        return after, Command(speeds, turn, reference.closed, opening), status

    def _grips(self, state: State, closed: Flags, measured: Measurement, load: Array) -> tuple[State, Array]:
        """Verify grips that close, watch those that hold."""
        firm = measured.grip >= HELD * self._robot.gripper.force
        held = closed & (state.held | firm)
        fresh = held & ~state.held
        mark = np.where(fresh[:, None], measured.passed, state.mark)
        passed = np.hypot(*(measured.passed - mark).T)
        return State(held, mark, load), np.where(held, passed, 0.0)
