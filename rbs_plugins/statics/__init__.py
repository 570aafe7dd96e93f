"""Equilibria: what is balanced, how it is solved, and what breaks on the way."""
