"""Measures: quantities derived from the state, each a relation that is computed when its trigger says so."""
