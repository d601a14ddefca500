"""Mathematics true of any parallel mechanism."""
