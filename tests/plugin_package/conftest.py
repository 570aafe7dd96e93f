"""Its own tests need the installed package; without it tests/conformance/test_plugin_package.py tests it."""

from importlib import metadata

if not any(point.name == "granite" for point in metadata.entry_points(group="rbs")):
    collect_ignore = ["tests"]
