"""Where it holds: maps on grids, proved boxes, boundaries along rays, interference with cables and stays."""
