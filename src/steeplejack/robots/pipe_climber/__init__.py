"""The pipe climber: 3-RPR parallel mechanism, remote-centre-of-motion linkage, two grippers.

What is here is the machine as data. Its mathematics is imported from the module it is about: `poses`, `inverse`,
`forward`, `certificate`, `jacobian`, `joints`, `screws`, `linkage`, `grippers`, `motion`,
`motion_file`, `sampled_motion`, `violations`, `singularity`,
`singular_path`, `singular_slice`, `statics`, `mechanism`.
"""

from steeplejack.robots.pipe_climber.layout import Layout
from steeplejack.robots.pipe_climber.parameters import BUILT_IN, SHIPPED, PipeClimber, load_pipe_climber

__all__ = ["BUILT_IN", "SHIPPED", "Layout", "PipeClimber", "load_pipe_climber"]
