"""Exporters: files for ParaView, tables, pictures."""
