"""The pipe climber in MuJoCo: scene, plant, and whole plans run in it."""
