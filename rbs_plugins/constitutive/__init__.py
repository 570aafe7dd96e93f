"""Constitutive models, failure and corrections."""
