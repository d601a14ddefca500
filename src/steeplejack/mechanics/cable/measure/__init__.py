"""How good a pose is and how that changes: conditioning, and exact derivatives in pose and anchors."""
