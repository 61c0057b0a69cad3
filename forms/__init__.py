"""Variational forms: functions that take fields and return UFL integrands. Nothing is solved here."""
