"""Where a platform comes to rest and how it swings: equilibria, slack cables, stiffness, modes, a lost cable."""
