"""Assembly modes of the 3-RPR mechanism: names for the four poses that three lengths allow.

Two signs tell the four solutions apart, each combination occurring exactly once: that of w (which side of the base the
platform is on) and that of det J (which side of the singular surface). The robot is built at w > 0 with the sign of
det J at home, and cannot leave either without passing w = 0 or a singularity. The paper's literature calls that a
working mode; strictly, working modes belong to inverse kinematics, where a limb of positive length leaves no choice.
"""

from __future__ import annotations

from typing import Literal

Mode = Literal["home", "across", "home-mirrored", "across-mirrored"]

MODES: tuple[Mode, Mode, Mode, Mode] = ("home", "across", "home-mirrored", "across-mirrored")
"""Order of the solutions: w > 0 before w < 0, and in each the sign of det J as at home before the other."""
