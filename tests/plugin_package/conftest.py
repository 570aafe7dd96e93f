"""Its own tests need the installed package; without it the main suite tests it by tests/conformance/test_plugin_package.py."""

from importlib import metadata

if not any(point.name == "granite" for point in metadata.entry_points(group="rbs")):
    collect_ignore = ["tests"]
