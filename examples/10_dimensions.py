"""10 Dimensions of the pipe climber: workspace, transmission, and the best lengths beside the published ones."""

import math
from dataclasses import replace

from steeplejack.design.climber import (
    ORIGINAL,
    PAPER,
    Comparison,
    Rectangle,
    design_plane,
    front,
    local_transmission,
    optimise,
    performance_chart,
    rating,
    read,
    readings,
    transmission_map,
    workspace_area,
)
from steeplejack.robots.pipe_climber import Layout, load_pipe_climber

layout = Layout.of(load_pipe_climber())
for neutral in ("none", "home", "normal"):
    areas = [workspace_area(replace(layout, neutral=neutral), math.radians(angle)) for angle in (-30, 0, 30)]
    print(f"joint limits from {neutral}: " + ", ".join(f"{area * 1e6:.0f} mm2" for area in areas))

pose = (0.020, 0.150, 0.0)
for moving in ("platform", "base"):
    print(f"transmission at {pose}, {moving} moving: {local_transmission(layout, pose, moving):.4f}")
print(f"GTI over the workspace {transmission_map(layout, 0.0005).gti:.3f}")

asked = Comparison(Rectangle(-0.050, 0.050, 0.130, 0.200), scale="l1")
best, gti = performance_chart(design_plane(0.01), asked).best()
print(f"original {rating(ORIGINAL, asked):.4f}, reported optimum {rating(PAPER, asked):.4f}")
print(f"best {gti:.4f} at " + " : ".join(f"{ratio:.2f}" for ratio in best))
found = optimise(asked, k=None, starts=1)
print(f"without a chart, L2 free too: {found.gti:.4f} at " + " : ".join(f"{ratio:.2f}" for ratio in found.ratio))

for one in readings(0.005)[:4]:
    seen = read(one, 0.1)
    region = "rectangle" if one.rectangle else f"workspace, joints from {one.neutral}"
    print(f"{region:<29} original {seen.original:.3f}, reported {seen.paper:.3f}, best {seen.best:.3f}")

aims = front(performance_chart(design_plane(0.1), Comparison(step=0.005)), 0.01)
print(
    f"{aims.best.sum()} of {len(aims.best)} designs are beaten by none in transmission, workspace, singularity and size"
)
