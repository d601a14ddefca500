"""Which wrenches a pose can hold: wrench closure, the available wrench set, feasibility, each with its certificate."""
