"""The command line: composes the rooms into commands. Names, keys and exit codes are a contract for scripts."""

from steeplejack.cli.program import COMMANDS, app, main

__all__ = ["COMMANDS", "app", "main"]
