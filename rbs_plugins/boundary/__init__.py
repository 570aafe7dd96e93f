"""Boundary domains."""
