"""Tensions that balance a wrench within limits: the line, polygon or polytope of them, and the ways to choose one."""
